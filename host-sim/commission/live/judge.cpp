#include "host-sim/commission/live/judge.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

#include "host-sim/commission/limits.hpp"

namespace smaservo::commission {
namespace {

/// The resistances that the wire of the settings can have when cold: as on the table, and stretched
/// by its load. A wire that has never been heated under the load may be between these.
std::pair<double, double> cold_range_ohm(const Prepared<double>& device, double stress_Pa,
                                         double ambient_K) {
  using Model = Plant<ThreePhase<double>>;
  const auto params = plant_params(device.settings.wire);
  const auto at = [&](double stress) {
    return Model::resistance_ohm(params, Model::rest(params, {ambient_K, stress}), ambient_K);
  };
  return std::minmax({at(0), at(stress_Pa)});
}

}  // namespace

std::string judge_load(const Prepared<double>& device, double stress_Pa) {
  const MeasurementSettings<double>& m = device.settings.measurement;
  const double area_m2 = device.settings.wire.geometry.area_m2();
  const double least_Pa = std::max(device.settings.trips.slack_Pa, least_stress_Pa);
  if (stress_Pa >= least_Pa) {
    return "";
  }
  if (!std::isfinite(stress_Pa)) {
    return m.has_load_cell ? "the load is missing: the load cell gives no reading"
                           : "the load is missing: measurement.constant_load_N is no number";
  }
  return fmt::format(
      "the load is missing: {} {:.3g} N, {:.3g} MPa; it must be at least {:.3g} N ({:.3g} MPa), or "
      "nothing stretches the wire as it cools",
      m.has_load_cell ? "the load cell reads" : "measurement.constant_load_N is",
      stress_Pa * area_m2, stress_Pa / 1e6, least_Pa * area_m2, least_Pa / 1e6);
}

std::string judge_leads(const Prepared<double>& device, const Means& cold) {
  const double wanted_A = device.settings.limits.min_current_A;
  if (!(cold.current_A >= least_current_share * wanted_A)) {
    return fmt::format(
        "the wire is open, or a lead is off: {:.3g} mA flow where {:.3g} mA are given, so there is "
        "no resistance; check the wire and both crimps",
        1e3 * cold.current_A, 1e3 * wanted_A);
  }
  // Half of the least resistance that the device itself believes.
  if (!(cold.resistance_ohm() >= 0.25 * device.cold_ohm)) {
    return fmt::format(
        "the sense leads read {:.3g} mV at {:.3g} mA, next to no resistance: a sense lead is off, "
        "or the wire is shorted",
        1e3 * cold.voltage_V, 1e3 * cold.current_A);
  }
  return "";
}

std::string judge_cold(const Prepared<double>& device, const Means& cold, double ambient_K) {
  const auto [low, high] = cold_range_ohm(device, cold.stress_Pa, ambient_K);
  const double measured = cold.resistance_ohm();
  const double expected = std::clamp(measured, low, high);
  const double share = measured / expected;
  if (std::abs(share - 1) <= most_cold_deviation) {
    return "";
  }
  const Geometry<double>& wire = device.settings.wire.geometry;
  const auto range = [](double from, double to) {
    const std::string first = fmt::format("{:.0f}", from);
    const std::string last = fmt::format("{:.0f}", to);
    return first == last ? first : fmt::format("{} to {}", first, last);
  };
  return fmt::format(
      "the cold resistance is {:.4g} ohm, {:.0f} % {} than that of the settings' wire, {:.4g} ohm "
      "(allowed: {:.0f} %): length, diameter or alloy differ; a wire.length of {} mm instead of "
      "{:.0f} mm would explain it, or a wire.diameter of {} um instead of {:.0f} um",
      measured, 100 * std::abs(share - 1), share > 1 ? "more" : "less", expected,
      100 * most_cold_deviation,
      range(1e3 * wire.length_m * measured / high, 1e3 * wire.length_m * measured / low),
      1e3 * wire.length_m,
      range(1e6 * wire.diameter_m * std::sqrt(low / measured),
            1e6 * wire.diameter_m * std::sqrt(high / measured)),
      1e6 * wire.diameter_m);
}

std::string judge_response(const Means& cold, const Means& hot, const std::string& limited) {
  const double fall = 1 - hot.resistance_ohm() / cold.resistance_ohm();
  if (fall >= least_response) {
    return "";
  }
  return fmt::format(
      "the wire does not transform: at {:.3g} mA its resistance {} by {:.1f} % ({:.4g} to {:.4g} "
      "ohm), and that of NiTi falls by 8 to 20 %; it is no shape-memory wire, its diameter is not "
      "that of the settings, the current is too small{}, or moving air cools it",
      1e3 * hot.current_A, fall < 0 ? "rises" : "falls", 100 * std::abs(fall),
      cold.resistance_ohm(), hot.resistance_ohm(),
      limited.empty() ? "" : fmt::format(" (limited by {})", limited));
}

}  // namespace smaservo::commission
