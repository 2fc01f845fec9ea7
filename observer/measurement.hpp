#pragma once
// Four-wire resistance of the wire from one sample of voltage and current.
// Source: 002 eq. 4 for two wires; observer/README.md for the noise.

#include <cmath>

#include "observer/estimate.hpp"

namespace smaservo {

/// One instant's readings, in SI. A reading that the front end could not take is NaN.
template <class S>
struct Sample {
  S current_A;
  S voltage_V;  ///< voltage between the sense leads
  S load_N;
};

/// The front end: offsets, noises, and the range in which a resistance is possible.
template <class S>
struct MeasurementParams {
  S area_m2;           ///< cross-section of the wire, from load to stress
  S current_offset_A;  ///< reading at zero current, which is subtracted
  S voltage_offset_V;
  S current_noise_A;  ///< standard deviations
  S voltage_noise_V;
  S lead_resistance_ohm;  ///< 0 with four wires; with two, the resistance of the leads (002 eq. 4)
  S min_current_A;        ///< a lower current gives no resistance, only noise
  /// A value outside means a broken wire or a short circuit.
  S min_resistance_ohm, max_resistance_ohm;
};

/// The resistance of a wire in series with a reference resistor, from the voltages over both
/// together and over the reference: 002 eq. 4. reference_V must not be zero.
template <class S>
constexpr S two_wire_resistance_ohm(const S& reference_ohm, const S& net_V, const S& reference_V,
                                    const S& lead_ohm) {
  return reference_ohm * (net_V / reference_V - S(1)) - lead_ohm;
}

/// Resistance, power and stress with their validity. A reading that is NaN or out of range
/// invalidates only the values computed from it. An invalid power is 0, as if the wire were not
/// heated.
template <class S>
Measurement<S> measure(const MeasurementParams<S>& p, const Sample<S>& sample) {
  using std::isfinite;
  using std::sqrt;
  Measurement<S> m{};
  const S I = sample.current_A - p.current_offset_A;
  const S V = sample.voltage_V - p.voltage_offset_V;
  m.stress_Pa = sample.load_N / p.area_m2;
  m.stress_valid = isfinite(m.stress_Pa);
  const S power_W = (V - I * p.lead_resistance_ohm) * I;
  m.power_valid = isfinite(power_W);
  if (!m.power_valid) {
    return m;
  }
  m.power_W = power_W;
  const S magnitude_A = I < S(0) ? -I : I;
  if (magnitude_A < p.min_current_A) {
    return m;
  }
  const S R = V / I - p.lead_resistance_ohm;
  // σ_R² = (σ_V² + R² σ_I²)/I²
  const S sense = V / I;
  m.resistance_ohm = R;
  m.resistance_sd_ohm = sqrt(p.voltage_noise_V * p.voltage_noise_V +
                             sense * sense * p.current_noise_A * p.current_noise_A) /
                        magnitude_A;
  m.resistance_valid = p.min_resistance_ohm <= R && R <= p.max_resistance_ohm;
  return m;
}

}  // namespace smaservo
