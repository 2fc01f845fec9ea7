// Strain from a recurrent network that was trained elsewhere (host-sim/papers/gru/train.py).

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>

#include "host-sim/papers/compare/system.hpp"
#include "host-sim/papers/fits/driven_steps.hpp"

namespace smaservo::compare {
namespace {

/// Behind a longer gap between two rows the network starts anew. It bounds the steps for a row.
constexpr double longest_gap_s = 10;

bool is_resistance(double ohm) {
  return std::isfinite(ohm) && ohm > 0;
}

/// The inputs of the network between the rows of a run.
class Course {
 public:
  /// The run needs at least one row with a resistance.
  explicit Course(const identify::Run& run)
      : run_(run), steps_(fits::every_row(run)), ohm_(run.resistance_ohm), energy_J_(ohm_.size()) {
    first_ohm_ = *std::ranges::find_if(ohm_, is_resistance);
    double held_ohm = first_ohm_;
    for (std::size_t i = 0; i < ohm_.size(); ++i) {
      held_ohm = is_resistance(ohm_[i]) ? ohm_[i] : held_ohm;
      ohm_[i] = held_ohm;
      energy_J_[i] = i == 0 ? 0 : energy_J_[i - 1] + steps_.power_W[i] * steps_.dt_s[i];
    }
  }

  /// At a row, where the network starts.
  gru::Inputs start(std::size_t row) {
    row_ = row;
    last_J_ = energy_J_[row];
    return {ohm_[row] / first_ohm_, run_.current_A[row] * run_.voltage_V[row],
            steps_.stress_Pa[row] / 1e6};
  }

  /// A step later. Rows are asked for in order; the time is not beyond the last one.
  gru::Inputs next(double at_s, double step_s) {
    const std::vector<double>& time_s = run_.time_s;
    while (row_ + 2 < time_s.size() && time_s[row_ + 1] <= at_s) {
      ++row_;
    }
    const double share =
        std::clamp((at_s - time_s[row_]) / (time_s[row_ + 1] - time_s[row_]), 0.0, 1.0);
    const auto between = [&](const std::vector<double>& values) {
      return values[row_] + share * (values[row_ + 1] - values[row_]);
    };
    // The mean power over the step, so that no energy is lost however far apart the rows are.
    const double before_J = last_J_;
    last_J_ = between(energy_J_);
    return {between(ohm_) / first_ohm_, (last_J_ - before_J) / step_s,
            between(steps_.stress_Pa) / 1e6};
  }

 private:
  const identify::Run& run_;
  fits::DrivenSteps steps_;
  std::vector<double> ohm_;  ///< a row without one has the last
  std::vector<double> energy_J_;
  double first_ohm_, last_J_ = 0;
  std::size_t row_ = 0;
};

/// Runs the network from one row to another, and puts the strain of each row between its steps.
void follow(const gru::Network& network, const identify::Run& run, Course& course,
            std::size_t begin, std::size_t end, std::vector<double>& strain) {
  gru::Cell cell(network);
  double now = cell.next(course.start(begin));
  double before = now;
  const double start_s = run.time_s[begin];
  // As train.py: a step that rounding has put behind the last row is still one.
  const double steps = std::floor((run.time_s[end - 1] - start_s) / network.step_s + 1e-6);
  double step = 0;
  for (std::size_t i = begin; i < end; ++i) {
    const double wanted = (run.time_s[i] - start_s) / network.step_s;
    while (step < wanted && step < steps) {
      ++step;
      before = now;
      now = cell.next(course.next(start_s + step * network.step_s, network.step_s));
    }
    const double share = std::clamp(wanted - (step - 1), 0.0, 1.0);
    strain[i] = before + share * (now - before);
  }
}

std::vector<double> strain_of(const gru::Network& network, const identify::Run& run) {
  constexpr double no_value = std::numeric_limits<double>::quiet_NaN();
  std::vector<double> strain(run.strain.size(), no_value);
  if (run.kind != identify::RunKind::joule ||
      std::ranges::none_of(run.resistance_ohm, is_resistance)) {
    return strain;
  }
  Course course(run);
  const std::size_t rows = run.time_s.size();
  for (std::size_t begin = 0; begin < rows;) {
    std::size_t end = begin + 1;
    while (end < rows && run.time_s[end] - run.time_s[end - 1] <= longest_gap_s) {
      ++end;
    }
    follow(network, run, course, begin, end, strain);
    begin = end;
  }
  // A row without a resistance holds the last estimate, as a device would.
  double held = no_value;
  for (std::size_t i = 0; i < rows; ++i) {
    held = is_resistance(run.resistance_ohm[i]) ? strain[i] : held;
    strain[i] = held;
  }
  return strain;
}

/// Whether the network was trained on a run, whatever its name.
bool knows(const gru::Network& network, const identify::Run& run) {
  return std::ranges::find(network.runs, gru::checksum_of(run.strain),
                           &gru::TrainingRun::checksum) != network.runs.end();
}

std::string remark(const gru::Network& network, const std::vector<identify::Run>& training,
                   const std::vector<identify::Run>& tests) {
  std::string said;
  for (const identify::Run& run : tests) {
    if (knows(network, run)) {
      said += (said.empty()
                   ? "was trained on runs that are tests here, so its errors there prove nothing: "
                   : ", ") +
              identify::file_name(run.name);
    }
  }
  const bool same =
      network.runs.size() == training.size() &&
      std::ranges::all_of(training, [&](const auto& run) { return knows(network, run); });
  if (!same) {
    said += said.empty() ? "" : "; ";
    said += "was trained on other runs than the other systems: ";
    for (const gru::TrainingRun& run : network.runs) {
      said += (&run == &network.runs.front() ? "" : ", ") + run.name;
    }
  }
  return said;
}

}  // namespace

System recurrent_network(const gru::Network& network, const std::vector<identify::Run>& training,
                         const std::vector<identify::Run>& tests) {
  return {"GRU",
          fmt::format("a recurrent network of {} units, trained by host-sim/papers/gru/train.py",
                      network.hidden()),
          network.parameters(), remark(network, training, tests),
          [network](const identify::Run& run) { return strain_of(network, run); }};
}

}  // namespace smaservo::compare
