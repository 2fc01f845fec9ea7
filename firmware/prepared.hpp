#pragma once
// Settings and the values derived from them, which are computed once per change, outside the loop.

#include <cmath>

#include "firmware/settings.hpp"
#include "model/wire/plant.hpp"
#include "observer/measurement.hpp"
#include "observer/multiple_model.hpp"
#include "observer/substepping.hpp"

namespace smaservo {

/// A device's settings with all that the loop needs of them; prepare() makes it.
template <class S>
struct Prepared {
  using Observer = Substepping<MultipleModelFilter<S>>;

  Settings<S> settings;
  MeasurementParams<S> measurement;
  typename Observer::Params observer;
  S cold_ohm;  ///< resistance of the wire at rest, at 25 °C and without load, by its file
};

template <class S>
KalmanTuning<S> observer_tuning(const Settings<S>& settings) {
  KalmanTuning<S> tuning = kalman_tuning(settings.wire.accuracy);
  tuning.start_ambient_sd_K = settings.observer.start_ambient_sd_K;
  tuning.start_loss_sd = settings.observer.start_loss_sd;
  return tuning;
}

/// Cost: some microseconds on a PC, a hyperbolic cosine among them; not for the loop.
template <class S>
Prepared<S> prepare(const Settings<S>& settings) {
  const Wire<S>& wire = settings.wire;
  const MeasurementSettings<S>& m = settings.measurement;
  const S ohm = cold_resistance_ohm(wire);
  return {settings,
          {wire.geometry.area_m2(), m.current_offset_A, m.voltage_offset_V, m.current_noise_A,
           m.voltage_noise_V, m.lead_resistance_ohm, S(0.5) * settings.limits.min_current_A,
           S(0.5) * ohm, S(2) * ohm},
          {plant_params(wire), observer_tuning(settings),
           m.has_load_cell ? S(0) : settings.axis.stop_strain},
          ohm};
}

}  // namespace smaservo
