#pragma once
// Readings of the sensors while no current is given. They are measured at start and updated
// whenever the device is off, because these offsets vary with temperature. Without this correction
// a sense current of a few percent of the greatest current could not be measured.

#include "firmware/safety/monitor/inputs.hpp"
#include "model/scalar/scalar.hpp"

namespace smaservo {

/// All zero: nothing has been seen.
template <class S>
struct ZeroCurrent {
  S current_A, voltage_V;  ///< mean readings, beyond the offsets of the settings
  S samples;

  static constexpr S min_samples = S(20);
  /// Up to this number of samples the mean is that of all samples; then old ones are forgotten
  /// exponentially.
  static constexpr S max_samples = S(1000);
  /// Time after switching off until the readings have settled.
  static constexpr S settling_s = S(0.02);

  bool known() const { return !(samples < min_samples); }
  bool in_band(const Prepared<S>& p) const {
    return magnitude(current_A) <= p.settings.trips.current_offset_A;
  }

  /// Takes a sample without current. Readings that are not numbers, or too large for an offset, do
  /// not count: the monitors report them.
  void take(const Prepared<S>& p, const Sample<S>& sample) {
    const MeasurementSettings<S>& q = p.settings.measurement;
    const S I = sample.current_A - q.current_offset_A;
    const S V = sample.voltage_V - q.voltage_offset_V;
    const bool plausible = magnitude(I) < S(4) * p.settings.trips.current_offset_A;
    if (!plausible || !isfinite(V)) {
      return;
    }
    samples = samples < max_samples ? samples + S(1) : samples;
    current_A += (I - current_A) / samples;
    voltage_V += (V - voltage_V) / samples;
  }

  /// The sample as an ideal front end would read it.
  Sample<S> corrected(const Prepared<S>& p, const Sample<S>& sample) const {
    if (!known() || !in_band(p)) {
      return sample;
    }
    return {sample.current_A - current_A, sample.voltage_V - voltage_V, sample.load_N};
  }
};

}  // namespace smaservo
