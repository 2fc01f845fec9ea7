#include "host-sim/identify/fit/judge/observed_run.hpp"

#include <cmath>
#include <limits>

#include "observer/estimator.hpp"
#include "observer/multiple_model.hpp"
#include "observer/substepping.hpp"

namespace smaservo::identify {
namespace {

constexpr double observed_step_s = 4e-3;
constexpr double ambient_errors_K[] = {-4, 4};
constexpr double resistance_gains[] = {0.995, 1.005};

/// The mean of the measurements of these rows, without the ones that are not valid. `area_m2`: with
/// which the run's stress was computed from its load.
Measurement<double> mean_of_rows(const MeasurementParams<double>& front_end, double area_m2,
                                 const Run& run, std::size_t from, std::size_t to) {
  Measurement<double> sum{};
  double powers = 0, stresses = 0, ohms = 0;
  for (std::size_t i = from; i < to; ++i) {
    const Measurement<double> m =
        measure(front_end, {run.current_A[i], run.voltage_V[i], run.stress_Pa[i] * area_m2});
    sum.power_W += m.power_valid ? m.power_W : 0;
    powers += m.power_valid ? 1 : 0;
    sum.stress_Pa += m.stress_valid ? m.stress_Pa : 0;
    stresses += m.stress_valid ? 1 : 0;
    sum.resistance_ohm += m.resistance_valid ? m.resistance_ohm : 0;
    sum.resistance_sd_ohm += m.resistance_valid ? m.resistance_sd_ohm : 0;
    ohms += m.resistance_valid ? 1 : 0;
  }
  const auto over = [](double total, double count) { return count > 0 ? total / count : 0; };
  sum.power_W = over(sum.power_W, powers);
  sum.power_valid = powers > 0;
  sum.stress_Pa = over(sum.stress_Pa, stresses);
  sum.stress_valid = stresses > 0;
  sum.resistance_ohm = over(sum.resistance_ohm, ohms);
  sum.resistance_sd_ohm = over(sum.resistance_sd_ohm, ohms);
  sum.resistance_valid = ohms > 0;
  return sum;
}

}  // namespace

ObserverErrors& ObserverErrors::operator+=(const ObserverErrors& other) {
  sum += other.sum;
  within_2_sd += other.within_2_sd;
  count += other.count;
  return *this;
}

ObservedRun observed_run(const Run& run, const Assumed<double>& as_fitted) {
  MeasurementParams<double> front_end = good_front_end(as_fitted.wire);
  front_end.lead_resistance_ohm = as_fitted.circuit.lead_ohm;
  const double area_m2 = front_end.area_m2;
  front_end.area_m2 *= as_fitted.circuit.load_gain;
  ObservedRun observed;
  observed.ambient_K = as_fitted.here.ambient_K;
  for (std::size_t from = 0; from + 1 < run.time_s.size();) {
    std::size_t to = from + 1;
    while (to + 1 < run.time_s.size() &&
           run.time_s[to + 1] - run.time_s[from] < 1.25 * observed_step_s) {
      ++to;
    }
    observed.dt_s.push_back(run.time_s[to] - run.time_s[from]);
    observed.seen.push_back(mean_of_rows(front_end, area_m2, run, from + 1, to + 1));
    observed.strain.push_back(run.strain.empty() ? std::numeric_limits<double>::quiet_NaN()
                                                 : run.strain[to] - as_fitted.here.strain_zero);
    from = to;
  }
  return observed;
}

ObserverErrors observer_errors(const ObservedRun& run, const Wire<double>& wire) {
  using Observer = Substepping<MultipleModelFilter<double>>;
  const Observer::Params params{plant_params(wire), kalman_tuning(wire.accuracy)};
  ObserverErrors errors;
  for (const double ambient_error_K : ambient_errors_K) {
    for (const double gain : resistance_gains) {
      const auto seen = [&](std::size_t i) {
        Measurement<double> m = run.seen[i];
        m.resistance_ohm *= gain;
        return m;
      };
      Observer::State state = Observer::start(params, seen(0), run.ambient_K + ambient_error_K);
      double now_s = 0;
      for (std::size_t i = 0; i < run.dt_s.size(); ++i) {
        now_s += run.dt_s[i];
        Observer::advance(params, state, seen(i), run.dt_s[i]);
        if (now_s < observer_settles_s || std::isnan(run.strain[i])) {
          continue;
        }
        const Estimate<double> e = Observer::estimate(params, state);
        const double error = std::abs(e.strain - run.strain[i]);
        errors.sum += error;
        errors.within_2_sd += error <= 2 * e.strain_sd ? 1U : 0U;
        ++errors.count;
      }
    }
  }
  return errors;
}

}  // namespace smaservo::identify
