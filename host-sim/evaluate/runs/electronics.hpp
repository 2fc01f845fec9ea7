#pragma once
// The sensors and the converter of all simulated runs of `evaluate`.

#include <limits>

#include "hal/sim/board.hpp"
#include "model/units.hpp"
#include "model/wire/wire.hpp"

namespace smaservo::evaluate {

/// 16 bits over 0.5 A, 20 V and 5 N; noise of 10 uA, 0.3 mV, and of a load that causes 0.5 MPa in
/// the wire.
inline hal::Sensors sensors(const Geometry<double>& geometry, double load_gain,
                            double resistance_gain) {
  return {.bits = 16,
          .current_full_scale_A = 0.5,
          .voltage_full_scale_V = 20,
          .load_full_scale_N = 5,
          .current_noise_A = 10e-6,
          .voltage_noise_V = 0.3e-3,
          .load_noise_N = 0.5e6 * geometry.area_m2(),
          .load_gain = load_gain,
          .resistance_gain = resistance_gain};
}

/// A converter that reaches 0.5 A at once, with leads of 0.1 ohm.
inline hal::Converter converter(bool voltage_drive) {
  return {.voltage_drive = voltage_drive,
          .max_A = 0.5,
          .slew_A_s = std::numeric_limits<double>::infinity(),
          .lead_ohm = 0.1};
}

}  // namespace smaservo::evaluate
