#include "host-sim/commission/broad.hpp"

#include <map>
#include <string_view>

#include "host-sim/commission/scaled.hpp"
#include "host-sim/identify/fit/parameters.hpp"
#include "model/wire/plant.hpp"

namespace smaservo::commission {
namespace {

/// Means of the fits of eight wires, in prior deviations of `identify` (parameters.hpp). Means
/// within a quarter of a deviation of 0, and those that differ between wires by more than
/// themselves, are left out.
const std::map<std::string_view, double>& deviations() {
  static const std::map<std::string_view, double> means{
      {"wire.m2a.temperature", -0.46},
      {"wire.m2a.temperature_stress", -0.86},
      {"wire.m2a.temperature_bend", 0.27},
      {"wire.m2a.width", 1.41},
      {"wire.m2a.curvature", -4.85},
      {"wire.m2a.turning", 1.16},
      {"wire.a2m.temperature_stress", -0.93},
      {"wire.a2m.width", 1.75},
      {"wire.a2m.curvature", -4.49},
      {"wire.a2m.turning", -1.16},
      {"wire.a2r.temperature", -0.61},
      {"wire.a2r.temperature_stress", 0.37},
      {"wire.a2r.width", 1.86},
      {"wire.a2r.curvature", -2.10},
      {"wire.a2r.turning", -1.44},
      {"wire.r2a.temperature", -1.84},
      {"wire.r2a.temperature_stress", -2.37},
      {"wire.r2a.temperature_bend", 1.09},
      {"wire.r2a.width", 1.46},
      {"wire.r2a.curvature", -4.35},
      {"wire.r2a.turning", 0.85},
      {"wire.martensite.strain", 0.35},
      {"wire.martensite.resistivity_temperature", 0.58},
      {"wire.r_phase.strain", -0.99},
      {"wire.r_phase.modulus", -1.78},
      {"wire.r_phase.resistivity_ratio", 0.53},
      {"wire.r_phase.resistivity_stress", 0.41},
      {"wire.austenite.resistivity_temperature", 0.32},
      {"wire.heat.specific_heat", 1.77},
      {"wire.heat.latent_r2a_share", 1.67},
      {"wire.heat.convection", 0.77}};
  return means;
}

}  // namespace

Wire<double> broad_wire(const Wire<double>& from) {
  identify::FitVariant variant;
  variant.separate_r2a = true;
  variant.separate_r2m = from.kinetics.separate_r2m;
  variant.memory = from.kinetics.memory;
  variant.mixture = from.material.mixture;
  // The means were found with this prior of the specific heat.
  variant.wire_temperature = true;
  Wire<double> begin = from;
  if (!from.kinetics.separate_r2a) {
    begin.kinetics.r2a = from.kinetics.m2a;
  }
  const Wire<double> broad =
      identify::vary_wire<double>(begin, variant, [](const identify::FitParameter& parameter) {
        const auto found = deviations().find(parameter.key);
        return parameter.value(found == deviations().end() ? 0.0 : found->second);
      });
  return with_resistance(broad, cold_resistance_ohm(from) / cold_resistance_ohm(broad));
}

}  // namespace smaservo::commission
