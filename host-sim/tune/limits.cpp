#include "host-sim/tune/limits.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

#include "firmware/parameters/parameters.hpp"
#include "host-sim/replay/measurement_params.hpp"
#include "host-sim/tune/estimate_noise.hpp"
#include "host-sim/tune/linear/uncertainty.hpp"
#include "host-sim/tune/output/rounding.hpp"
#include "model/files/error.hpp"
#include "model/units.hpp"

namespace smaservo::tune {
namespace {

/// The whole stroke at the current limit takes this time, or this share of the time for stretching.
constexpr double stroke_s = 0.1;
constexpr double stroke_share = 0.2;
constexpr double max_rate_1_s = 0.35;  ///< at a faster rate the cold ends heat along with the wire
constexpr double resistance_share = 1e-3;  ///< noise of the resistance at the least current
constexpr double sense_heating_K = 2;      ///< heating that the least current may cause
constexpr double slack_Pa = 1e6;
constexpr double min_limit_Pa = 10e6;  ///< least limit of the stress, well above slack

/// The current at which the resistance is measured well, unless it warms the wire too much.
double min_current_A(const MeasurementSettings<double>& m, const LumpedModel::Params& params,
                     double ohm) {
  const double measures_A = resistance_noise_ohm(m, ohm, 1) / (resistance_share * ohm);
  const double warms_A = std::sqrt(params.body.loss_W(sense_heating_K) / ohm);
  return std::min(measures_A, warms_A);
}

double hottest_loss_W(const TuneTask& task, const Branches& b) {
  const LumpedModel::Params params = lumped_params(task.plant);
  return params.body.loss_W(b.hottest_K - task.plant.ambient_K);
}

/// The temperature at the end of the stroke, or the higher one with which a wire can be held at 90
/// % of it in the greatest draught: in the long run the device gives no more power than the file's
/// wire takes up at the limit, times the margin.
double max_estimate_K(const TuneTask& task, const Branches& b, double loss_margin) {
  const LumpedModel::Params params = lumped_params(task.plant);
  double contracted_K = 0;
  for (const OperatingPoint& p : b.points) {
    contracted_K = std::max(contracted_K, p.temperature_K);
  }
  const double ambient_K = task.plant.ambient_K;
  const double held_W = max_draught * params.body.loss_W(contracted_K + 2 - ambient_K);
  double estimate_K = b.hottest_K + 3;
  while (loss_margin * params.body.loss_W(estimate_K - ambient_K) < held_W) {
    estimate_K += 1;
  }
  return estimate_K;
}

void choose_rates(const Branches& b, const TuneTask& task, Settings<double>& s) {
  const double spare_W =
      s.limits.current_A * s.limits.current_A * b.min_ohm - 0.5 * hottest_loss_W(task, b);
  const double can_1_s = 0.9 * spare_W * b.stroke() / b.heat_J;
  s.trajectory.heating_rate_1_s = rounded_down(std::min(max_rate_1_s, can_1_s));
  s.trajectory.cooling_rate_1_s = rounded_up(max_draught * b.fastest_cooling_1_s);
  s.trips.following_s = rounded_up(std::max(2.0, 3 * b.cooling_s));
}

}  // namespace

double resistance_noise_ohm(const MeasurementSettings<double>& m, double ohm, double current_A) {
  return std::hypot(m.voltage_noise_V, ohm * m.current_noise_A) / current_A;
}

Settings<double> bare_settings(const Wire<double>& wire, double current_A) {
  const MeasurementParams<double> front_end = replay::measurement_params(wire, {});
  const double full_V = rounded_up(1.5 * current_A * cold_resistance_ohm(wire));
  Settings<double> s = default_settings<double>();
  s.wire = wire;
  s.measurement.current_noise_A = rounded_up(front_end.current_noise_A);
  s.measurement.voltage_noise_V = rounded_up(front_end.voltage_noise_V);
  s.measurement.current_full_scale_A = rounded_up(1.25 * current_A);
  s.measurement.voltage_full_scale_V = full_V;
  for (LoopGains<double>* loop : {&s.strain, &s.temperature, &s.resistance, &s.force}) {
    loop->proportional = loop->integral_1_s = loop->derivative_s = loop->dead_band = 0;
  }
  s.limits.current_A = current_A;
  return s;
}

void require_motion(const TuneTask& task, const Branches& b) {
  const auto count = [&](Motion motion) {
    return std::ranges::count(b.points, motion, &OperatingPoint::motion);
  };
  if (b.stroke() < 0.1 * task.plant.wire.nominal_stroke || count(Motion::heating) < 5 ||
      count(Motion::cooling) < 5) {
    throw files::UserError(fmt::format(
        "in air of {:.4g} °C under {:.4g} MPa: the wire contracts by {:.2g} % up to {:.4g} °C and "
        "stretches again over only {} of 9 parts of it; use colder air or another load",
        task.plant.ambient_K - zero_degC_K, 1e-6 * task.plant.load.low_Pa, 100 * b.stroke(),
        b.hottest_K - zero_degC_K, count(Motion::cooling)));
  }
}

void choose_limits(const TuneTask& task, Proposal& p) {
  const Branches& b = p.branches;
  const Wire<double>& wire = task.plant.wire;
  const double hold_W = max_draught * hottest_loss_W(task, b);
  p.holding_A = std::sqrt(hold_W / b.min_ohm);
  const double stroke_A = std::sqrt(
      (b.heat_J / std::max(stroke_s, stroke_share * b.cooling_s) + 0.5 * hottest_loss_W(task, b)) /
      b.min_ohm);
  const double wanted_A = rounded_up(std::max(stroke_A, 1.2 * p.holding_A));
  const double current_A = std::min(wanted_A, task.max_current_A);
  if (current_A < p.holding_A) {
    throw files::UserError(
        fmt::format("--current-A {}: must be at least the {:.3g} A that hold this "
                    "wire short in a draught",
                    task.max_current_A, p.holding_A));
  }
  Settings<double>& s = p.settings;
  s = bare_settings(wire, current_A);
  p.supply_V = rounded_up(1.1 * current_A * b.max_ohm);
  SoftLimits<double>& q = s.limits;
  q.min_current_A = rounded_up(
      min_current_A(s.measurement, lumped_params(task.plant), cold_resistance_ohm(wire)));
  q.power_W = rounded_up(current_A * current_A * b.max_ohm);
  q.temperature_K = std::min(wire.limits.temperature_K,
                             std::ceil(max_estimate_K(task, b, q.loss_margin) + q.hot_spot_K));
  q.min_strain = 1e-4 * std::floor(1e4 * (b.hot_strain + 0.01 * b.stroke()));
  q.max_strain = 1e-4 * std::ceil(1e4 * b.rest_strain);
  const double max_Pa = std::max(task.plant.load.low_Pa, b.hot_Pa);
  q.stress_Pa = std::min(wire.limits.stress_Pa, rounded_up(std::max(1.25 * max_Pa, min_limit_Pa)));
  const double share = std::max(wire.limits.current_A, 1.05 * p.holding_A) / current_A;
  q.duty = share < 1 ? rounded_up(share * share) : 1;
  s.trips.current_A = rounded_up(1.15 * current_A);
  s.trips.temperature_K = q.temperature_K + 10;
  s.trips.stress_Pa = rounded_up(1.2 * q.stress_Pa);
  s.trips.slack_Pa = std::min(slack_Pa, task.plant.load.low_Pa - 2 * slack_Pa);
  s.trips.current_offset_A =
      std::min(s.trips.current_offset_A, rounded_down(0.3 * q.min_current_A));
  s.trips.min_strain = q.min_strain - 0.005;
  s.trips.max_strain = q.max_strain + 0.01;
  s.axis.zero_strain = q.max_strain;
  s.measurement.constant_load_N = rounded_up(task.plant.load.low_Pa * wire.geometry.area_m2());
  choose_rates(b, task, s);
}

double resistance_dead_band_ohm(const Proposal& p) {
  double max = 0;
  for (const OperatingPoint& at : p.branches.points) {
    const double holding_A = std::sqrt(at.loss_W / at.ohm);
    max = std::max(max, resistance_noise_ohm(p.settings.measurement, at.ohm, holding_A));
  }
  return 3 * max;
}

double min_dead_band(const TuneTask& task, const Proposal& p) {
  const double noise = estimate_noise(task.plant, p);
  return rounded_up(std::max(3 * noise, 0.1 * task.plant.wire.accuracy.strain));
}

}  // namespace smaservo::tune
