#pragma once

#include "firmware/canopen/servo/parameter_access.hpp"
#include "firmware/settings.hpp"

namespace smaservo::canopen {

/// At what the settings have: any raise is one too much.
inline Ceilings ceilings_at(const Settings<double>& settings) {
  const auto f = [](double x) { return static_cast<float>(x); };
  return {.current_A = f(settings.limits.current_A),
          .power_W = f(settings.limits.power_W),
          .temperature_K = f(settings.limits.temperature_K),
          .stress_Pa = f(settings.limits.stress_Pa),
          .trip_current_A = f(settings.trips.current_A),
          .trip_temperature_K = f(settings.trips.temperature_K),
          .trip_stress_Pa = f(settings.trips.stress_Pa)};
}

}  // namespace smaservo::canopen
