#include "host-sim/choose/cycle.hpp"

#include <algorithm>
#include <cmath>

namespace smaservo::choose {
namespace {

using Plant = WirePlant<double>;

/// A step is at most this long, a fiftieth of the wire's own time in still air, and a part of the
/// heating.
constexpr double longest_step_s = 5e-3;
constexpr double steps_of_a_heating = 400;

double step_s(const Plant& plant, double draught) {
  const auto& body = plant.params().body;
  return std::min(body.capacity_J_K / body.loss_W_K / 50 / draught, longest_step_s);
}

/// A wire that pulls on its load, from rest.
class Loaded {
 public:
  explicit Loaded(const CycleTask& task)
      : task_(task),
        plant_(task.wire, task.pull.cold_N(), task.ambient_K),
        rest_strain_(plant_.output().strain) {}
  Loaded(const CycleTask& task, const Contracted& from)
      : task_(task), plant_(from.plant), rest_strain_(from.rest_strain) {}

  /// `load_N` is what pulls beside the spring.
  void step(double current_A, double load_N, double draught, double dt_s) {
    WireInput<double> in{.current_A = current_A,
                         .load_N = load_N + task_.pull.preload_N,
                         .ambient_K = task_.ambient_K,
                         .draught = draught};
    if (task_.pull.rate_N_m > 0) {
      in.load_N = with_spring_N(in, load_N, dt_s);
    }
    plant_.update(in, dt_s);
  }

  double contraction_m() const { return contraction_m(plant_.output()); }
  bool has_contracted() const { return contraction_m() >= task_.contraction_m; }
  bool is_too_hot() const {
    return plant_.output().temperature_K > task_.wire.limits.temperature_K;
  }
  const Plant& plant() const { return plant_; }
  double rest_strain() const { return rest_strain_; }

 private:
  double contraction_m(const WireOutput<double>& out) const {
    return task_.wire.geometry.length_m * (rest_strain_ - out.strain);
  }
  double spring_N(double contraction_m) const {
    return task_.pull.preload_N + task_.pull.rate_N_m * std::max(0.0, contraction_m);
  }
  /// The load with which the spring pulls as it does at the end of the step, since a wire may be
  /// softer than its spring. More load means less contraction and less pull, so that the load lies
  /// between that of the stretched spring and the answer to it; regula falsi (Illinois).
  double with_spring_N(WireInput<double> in, double load_N, double dt_s) const {
    const auto excess_N = [&](double N) {
      in.load_N = N;
      return N - load_N - spring_N(contraction_m(plant_.after(in, dt_s)));
    };
    double low_N = load_N + task_.pull.preload_N;
    double low_excess_N = excess_N(low_N);
    double high_N = low_N - low_excess_N;
    double high_excess_N = excess_N(high_N);
    double found_N = high_N;
    constexpr int rounds = 12;
    for (int i = 0; i < rounds && high_excess_N > low_excess_N; ++i) {
      found_N = high_N - high_excess_N * (high_N - low_N) / (high_excess_N - low_excess_N);
      const double excess = excess_N(found_N);
      if (std::abs(excess) <= 1e-6 * found_N) {
        break;
      }
      if (excess > 0) {
        high_N = found_N;
        high_excess_N = excess;
        low_excess_N *= 0.5;
      } else {
        low_N = found_N;
        low_excess_N = excess;
        high_excess_N *= 0.5;
      }
    }
    return found_N;
  }

  const CycleTask& task_;
  Plant plant_;
  double rest_strain_;
};

void add_to(Course& course, double time_s, const Loaded& wire) {
  course.time_s.push_back(time_s);
  course.contraction_m.push_back(wire.contraction_m());
  course.temperature_K.push_back(wire.plant().output().temperature_K);
}

enum class End : unsigned char { contracted, too_slow, too_hot };

struct Heated {
  End end;
  double seconds;  ///< until then
  double ohm;      ///< greatest resistance on the way
  Loaded wire;
};

/// A constant current for `seconds`, or until the wire has contracted or is too hot.
Heated heat(const CycleTask& task, double current_A, double seconds, Course* course = nullptr) {
  Heated heated{End::too_slow, 0, 0, Loaded(task)};
  Loaded& wire = heated.wire;
  const double longest_s = std::min(step_s(wire.plant(), 1), seconds / steps_of_a_heating);
  const double steps = std::ceil(seconds / longest_s);
  for (int i = 0; i < static_cast<int>(steps) && heated.end == End::too_slow; ++i) {
    if (course != nullptr) {
      add_to(*course, heated.seconds, wire);
    }
    wire.step(current_A, task.pull.load_N, 1, seconds / steps);
    heated.seconds = (i + 1) * seconds / steps;
    heated.ohm = std::max(heated.ohm, wire.plant().output().resistance_ohm);
    heated.end = wire.has_contracted() ? End::contracted
                 : wire.is_too_hot()   ? End::too_hot
                                       : End::too_slow;
  }
  return heated;
}

/// Time, from the start, until this current makes the wire too hot.
std::optional<double> overheats(const CycleTask& task, const Heated& heated, double current_A) {
  Loaded wire = heated.wire;
  const auto& body = wire.plant().params().body;
  const double limit_W = body.loss_W(task.wire.limits.temperature_K - task.ambient_K);
  const double dt_s = std::min(step_s(wire.plant(), 1), heated.seconds / steps_of_a_heating);
  for (double t = heated.seconds; t < longest_heating_s; t += dt_s) {
    const double power_W = current_A * current_A * wire.plant().output().resistance_ohm;
    if (wire.is_too_hot()) {
      return t;
    }
    if (power_W <= limit_W) {
      return {};
    }
    wire.step(current_A, task.pull.load_N, 1, dt_s);
  }
  return {};
}

}  // namespace

double greatest_contraction_m(const CycleTask& task) {
  const Wire<double>& w = task.wire;
  const double length_m = w.geometry.length_m;
  const Plant cold(w, task.pull.cold_N(), task.ambient_K);
  const Plant hot(w, task.pull.contracted_N(task.contraction_m), w.limits.temperature_K);
  return length_m * (cold.output().strain - hot.output().strain);
}

std::optional<Contracted> contract(const CycleTask& task, double seconds) {
  double low_A = 0;
  double high_A = task.wire.limits.current_A;
  constexpr int most_doublings = 30;
  for (int i = 0;; ++i) {
    const End end = heat(task, high_A, seconds).end;
    if (end == End::too_hot || i == most_doublings) {
      return {};
    }
    if (end == End::contracted) {
      break;
    }
    low_A = high_A;
    high_A *= 2;
  }
  constexpr double exact = 1e-3;
  while (high_A - low_A > exact * high_A) {
    const double middle_A = 0.5 * (low_A + high_A);
    (heat(task, middle_A, seconds).end == End::contracted ? high_A : low_A) = middle_A;
  }
  Course course;
  const Heated heated = heat(task, high_A, seconds, &course);
  const auto now = heated.wire.plant().output();
  const auto& body = heated.wire.plant().params().body;
  return Contracted{heated.wire.plant(),
                    heated.wire.rest_strain(),
                    high_A,
                    heated.seconds,
                    heated.ohm,
                    now.temperature_K,
                    std::sqrt(body.loss_W(now.temperature_K - task.ambient_K) / now.resistance_ohm),
                    overheats(task, heated, high_A),
                    std::move(course)};
}

std::optional<double> stretch_again(const CycleTask& task, const Contracted& contracted,
                                    double draught, double left_m, Course* course) {
  Loaded wire(task, contracted);
  const double dt_s = step_s(wire.plant(), draught);
  const double load_N = task.pull.load_stays ? task.pull.load_N : 0;
  double before_m = wire.contraction_m();
  for (double t = 0; t < longest_stretch_s; t += dt_s) {
    const double x_m = wire.contraction_m();
    if (course != nullptr) {
      add_to(*course, t, wire);
    }
    if (x_m <= left_m) {
      // Between the last two steps.
      return x_m < before_m ? t - dt_s * (left_m - x_m) / (before_m - x_m) : t;
    }
    before_m = x_m;
    wire.step(0, load_N, draught, dt_s);
  }
  return {};
}

}  // namespace smaservo::choose
