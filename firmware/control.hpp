#pragma once
// From an estimate and a set-point to the current of the next step.

#include <cmath>

#include "firmware/command.hpp"
#include "firmware/prepared.hpp"

namespace smaservo {

/// What the controller knows of the wire in one step.
template <class S>
struct Known {
  const Measurement<S>& measurement;
  const Estimate<S>& estimate;
  const typename KalmanObserver<S>::State& filter;  ///< the most likely one: model state, air, loss
  S measured_A;
  S supply_V;  ///< NaN where it is not measured
};

/// What is asked of it.
template <class S>
struct Demand {
  Mode mode;
  S setpoint;
  GainScale<S> scale;
};

template <class S>
struct Controller {
  struct State {
    Mode mode;
    S reference;   ///< of the trajectory
    S integral_W;  ///< of the loop in force
    S filtered;    ///< the controlled variable, for its derivative
    S power_W;     ///< given in the last step
    S current_A;   ///< likewise
    S trim;        ///< integral part of the current loop
    S duty;        ///< average of the squared share of the current limit
    S elapsed_s;   ///< in this mode
  };

  struct Result {
    S current_A, voltage_V;
    S setpoint, reference, power_W;
    std::uint32_t limit_reasons;
  };

  /// No current: the loop starts afresh afterwards.
  static void rest(State& s, const S& dt_s);

  static Result step(const Prepared<S>& p, State& s, const Demand<S>& demand, const Known<S>& known,
                     const S& dt_s);
};

template <class S>
void Controller<S>::rest(State& s, const S& dt_s) {
  const S duty = s.duty - s.duty * dt_s;
  s = State{};
  s.duty = duty;
}

template <class S>
auto Controller<S>::step(const Prepared<S>& p, State& s, const Demand<S>& demand,
                         const Known<S>& known, const S& /*dt_s*/) -> Result {
  using std::sqrt;
  const Settings<S>& q = p.settings;
  const S above_K = known.estimate.temperature_K - known.filter.ambient_K;
  const S loss_W = known.filter.loss * p.observer.model.body.loss_W(above_K);
  const S ohm = known.measurement.resistance_valid ? known.measurement.resistance_ohm
                                                   : known.estimate.resistance_model_ohm;
  S power_W = loss_W + q.strain.proportional * (known.estimate.strain - demand.setpoint);
  const S most_W = q.limits.current_A * q.limits.current_A * ohm;
  const S least_W = q.limits.least_current_A * q.limits.least_current_A * ohm;
  power_W = power_W < least_W ? least_W : most_W < power_W ? most_W : power_W;
  s.mode = demand.mode;
  s.power_W = power_W;
  s.current_A = sqrt(power_W / ohm);
  return {s.current_A, s.current_A * ohm, demand.setpoint, demand.setpoint, power_W, 0};
}

}  // namespace smaservo
