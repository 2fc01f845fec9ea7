#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <limits>
#include <numeric>

#include "host-sim/checks/statistics.hpp"
#include "host-sim/identify/fit/fit.hpp"

namespace smaservo::identify {
namespace {

constexpr std::size_t max_compared = 1500;
constexpr double nothing = std::numeric_limits<double>::quiet_NaN();

double at(const std::vector<double>& column, std::size_t row) {
  return column.empty() ? nothing : column[row];
}

double resistance_at(const Run& run, std::size_t row) {
  if (!run.resistance_ohm.empty()) {
    return run.resistance_ohm[row];
  }
  const double ohm = at(run.voltage_V, row) / at(run.current_A, row);
  return std::isfinite(ohm) && ohm > 0 ? ohm : nothing;
}

/// Mean over a few rows to both sides, because the noise of a load would otherwise transform the
/// wire.
std::vector<double> smoothed(const std::vector<double>& column) {
  const std::size_t reach = std::min<std::size_t>(12, column.size() / 40);
  std::vector<double> means(column.size());
  for (std::size_t i = 0; i < column.size(); ++i) {
    const auto from = static_cast<std::ptrdiff_t>(i - std::min(i, reach));
    const auto to = static_cast<std::ptrdiff_t>(std::min(i + reach + 1, column.size()));
    means[i] = std::accumulate(column.begin() + from, column.begin() + to, 0.0) /
               static_cast<double>(to - from);
  }
  return means;
}

void compare(FitRun& fit, std::size_t step, double strain, double ohm, double power) {
  fit.after.push_back(step);
  fit.strain.push_back(strain);
  fit.resistance_ohm.push_back(ohm);
  fit.power_W_kg.push_back(power);
  fit.has_strain = fit.has_strain || !std::isnan(strain);
  fit.has_resistance = fit.has_resistance || !std::isnan(ohm);
}

/// The rate of heating or cooling around each row; NaN where the temperature turns or is held, or
/// where rows are missing. It is taken over a hundredth of the rows, however many there are in a
/// second: over few rows it would have the noise of the thermometer.
std::vector<double> rates(const Run& run) {
  const std::size_t rows = run.time_s.size();
  const std::size_t reach = std::max<std::size_t>(rows / 200, 1);
  std::vector<double> dt_s;
  for (std::size_t i = 1; i < rows; ++i) {
    dt_s.push_back(run.time_s[i] - run.time_s[i - 1]);
  }
  const double longest_s = 5 * checks::median(dt_s);
  std::vector<double> rate(rows, nothing);
  for (std::size_t i = reach; i + reach < rows; ++i) {
    const auto span = [&](std::size_t from, std::size_t to) {
      return run.temperature_K[to] - run.temperature_K[from];
    };
    const bool whole = std::all_of(dt_s.begin() + static_cast<std::ptrdiff_t>(i - reach),
                                   dt_s.begin() + static_cast<std::ptrdiff_t>(i + reach),
                                   [&](double dt) { return dt < longest_s; });
    const double before_K = span(i - reach, i);
    const double after_K = span(i, i + reach);
    // In a turn or at its side one half is much slower than the other.
    const double change = before_K / after_K;
    const bool steady = 0.5 < change && change < 2;
    if (whole && steady) {
      rate[i] = std::abs(before_K + after_K) / (run.time_s[i + reach] - run.time_s[i - reach]);
    }
  }
  return rate;
}

double middle_power_W_kg(const Run& run) {
  std::vector<double> up, down;
  for (std::size_t i = 1; i < run.power_W_kg.size(); ++i) {
    const double change_K = run.temperature_K[i] - run.temperature_K[i - 1];
    if (!std::isnan(run.power_W_kg[i]) && change_K != 0) {
      (change_K > 0 ? up : down).push_back(run.power_W_kg[i]);
    }
  }
  return up.empty() || down.empty() ? 0 : 0.5 * (checks::median(up) + checks::median(down));
}

/// Takes each row as a step: for a bath, settled states, and calorimetry.
void take_rows(const Run& run, FitRun& fit) {
  const std::size_t rows =
      run.kind == RunKind::settled ? run.current_A.size() : run.temperature_K.size();
  const std::size_t every = (rows + max_compared - 1) / max_compared;
  if (run.kind == RunKind::calorimetry) {
    fit.middle_power_W_kg = middle_power_W_kg(run);
    fit.rate_K_s = run.time_s.empty() ? std::vector<double>() : rates(run);
  }
  fit.stress_Pa = run.stress_Pa.empty() ? std::vector<double>(rows, 0.0) : smoothed(run.stress_Pa);
  for (std::size_t i = 0; i < rows; ++i) {
    if (run.kind == RunKind::settled) {
      fit.power_W.push_back(run.current_A[i] * run.voltage_V[i]);
      fit.current2_A2.push_back(run.current_A[i] * run.current_A[i]);
    } else {
      fit.power_W.push_back(0);
      fit.current2_A2.push_back(0);
      fit.temperature_K.push_back(run.temperature_K[i]);
    }
    if (i % every == 0) {
      const bool timed = fit.rate_K_s.empty() || !std::isnan(fit.rate_K_s[i]);
      compare(fit, i, at(run.strain, i), resistance_at(run, i),
              timed ? at(run.power_W_kg, i) : nothing);
    }
  }
}

/// The steps between two rows, with their energy and mean square of the current by the trapezoidal
/// rule, and the mean stress. A long gap is divided into substeps, with the power interpolated
/// linearly. `ends` is the row at the end of each step, 0 within a gap.
void take_steps(const Run& run, std::size_t from, std::size_t to, double step_s, FitRun& fit,
                std::vector<std::size_t>& ends) {
  const bool has_current = !run.current_A.empty();
  const bool imposed = run.kind == RunKind::imposed;
  const auto power_W = [&](std::size_t i) { return run.heating_W_at(i); };
  const auto square = [&](std::size_t i) {
    return has_current ? run.current_A[i] * run.current_A[i] : 0;
  };
  double energy_J = 0;
  double squares = 0;
  double stress_Pa = 0;
  for (std::size_t i = from; i < to; ++i) {
    const double dt_s = run.time_s[i + 1] - run.time_s[i];
    energy_J += 0.5 * (power_W(i) + power_W(i + 1)) * dt_s;
    squares += 0.5 * (square(i) + square(i + 1)) * dt_s;
    stress_Pa += run.stress_Pa[i + 1] / static_cast<double>(to - from);
  }
  const double span_s = run.time_s[to] - run.time_s[from];
  const auto parts = static_cast<std::size_t>(std::max(1.0, std::ceil(span_s / (1.25 * step_s))));
  for (std::size_t part = 0; part < parts; ++part) {
    const double share = (static_cast<double>(part) + 0.5) / static_cast<double>(parts);
    fit.dt_s.push_back(span_s / static_cast<double>(parts));
    fit.power_W.push_back(to == from + 1 ? power_W(from) + share * (power_W(to) - power_W(from))
                                         : energy_J / span_s);
    fit.current2_A2.push_back(squares / span_s);
    fit.stress_Pa.push_back(stress_Pa);
    if (imposed) {
      const double done = static_cast<double>(part + 1) / static_cast<double>(parts);
      fit.given_strain.push_back(run.strain[from] + done * (run.strain[to] - run.strain[from]));
    }
    ends.push_back(part + 1 == parts ? to : 0);
  }
}

/// The mean resistance over the last half of a step.
double mean_resistance(const Run& run, std::size_t row, double step_s) {
  double ohm = 0;
  int count = 0;
  for (std::size_t i = row; run.time_s[row] - run.time_s[i] < 0.6 * step_s; --i) {
    ohm += resistance_at(run, i);
    ++count;
    if (i == 0) {
      break;
    }
  }
  return ohm / count;
}

void take_time(const Run& run, double step_s, FitRun& fit) {
  if (run.kind == RunKind::imposed) {
    // The stress follows the strain, which is known at the rows only.
    std::vector<double> steps_s;
    std::ranges::transform(run.time_s.begin() + 1, run.time_s.end(), run.time_s.begin(),
                           run.time_s.end() - 1, std::back_inserter(steps_s), std::minus<>());
    step_s = std::max(step_s, checks::median(steps_s));
  }
  std::vector<std::size_t> ends;
  for (std::size_t from = 0; from + 1 < run.time_s.size();) {
    std::size_t to = from + 1;
    while (to + 1 < run.time_s.size() && run.time_s[to + 1] - run.time_s[from] < 1.25 * step_s) {
      ++to;
    }
    take_steps(run, from, to, step_s, fit, ends);
    from = to;
  }
  const std::size_t every = (ends.size() + max_compared - 1) / max_compared;
  std::size_t since = 0;
  for (std::size_t i = 0; i < ends.size(); ++i) {
    ++since;
    if (ends[i] != 0 && since >= every) {
      since = 0;
      if (run.kind == RunKind::imposed) {
        fit.after.push_back(i);
        fit.measured_stress_Pa.push_back(run.stress_Pa[ends[i]]);
        continue;
      }
      compare(fit, i, at(run.strain, ends[i]), mean_resistance(run, ends[i], step_s), nothing);
    }
  }
}

}  // namespace

FitRun thin_run(const Run& run, double step_s) {
  FitRun fit;
  fit.name = run.name;
  fit.kind = run.kind;
  if (!run.ambient_K.empty()) {
    fit.ambient_K = std::accumulate(run.ambient_K.begin(), run.ambient_K.end(), 0.0) /
                    static_cast<double>(run.ambient_K.size());
  }
  if (run.kind == RunKind::joule || run.kind == RunKind::imposed) {
    take_time(run, step_s, fit);
  } else {
    take_rows(run, fit);
  }
  return fit;
}

}  // namespace smaservo::identify
