#pragma once
// Inputs of the monitors, the supervisor and the check while arming, for one step.

#include "firmware/command.hpp"
#include "firmware/prepared.hpp"
#include "model/scalar/order.hpp"

namespace smaservo {

template <class S>
struct MonitorInputs {
  const Prepared<S>& prepared;
  const Inputs<S>& in;
  const Command<S>& command;
  const Measurement<S>& measurement;
  const Estimate<S>& estimate;
  const typename KalmanObserver<S>::State& filter;  ///< state of the most likely filter
  const Output<S>& last;  ///< output of the step before, to which this sample is the response
  S given_before_A;  ///< current given one step earlier than last.drive_current_A; a drive may be
                     ///< one step late
  S current_A, voltage_V;  ///< readings less their offsets
  S duty;                  ///< duty as the controller counts it
  S off_s;                 ///< time for which no current has been given
  S since_sample_s, since_command_s;
  S dt_s;
  bool observing;  ///< the observer has started, so estimate and filter are valid
  bool zeroed;     ///< the zero-current offset is known
  bool stalled;    ///< the loop stood still after the step before, see StalledTime

  bool off() const { return last.drive_current_A == S(0) && given_before_A == S(0); }
  bool heated() const { return is_heated(last.state); }
  S min_given_A() const {
    return given_before_A < last.drive_current_A ? given_before_A : last.drive_current_A;
  }
  S max_given_A() const {
    return given_before_A < last.drive_current_A ? last.drive_current_A : given_before_A;
  }
  bool sure() const { return observing && estimate.health == Health::good; }

  /// Whether the resistance of this sample is known within 0.1 %; at the minimum current it is not.
  bool precise() const {
    const MeasurementSettings<S>& q = prepared.settings.measurement;
    const S by_V = q.voltage_noise_V * current_A;
    const S by_I = q.current_noise_A * voltage_V;
    const S max = S(1e-3) * voltage_V * current_A;
    return measurement.resistance_valid && by_V * by_V + by_I * by_I < max * max;
  }

  /// Whether the current has been off for so long that the wire has the air's temperature, whatever
  /// it had before: ten time constants, and the time to give off the latent heat at 5 K above the
  /// air.
  bool cold() const {
    const ThermalBody<S>& body = prepared.observer.model.body;
    return S(10) * body.capacity_J_K + S(0.2) * body.latent_m2a_J < off_s * body.loss_W_K;
  }
};

}  // namespace smaservo
