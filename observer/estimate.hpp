#pragma once
// The interface of every observer: its input and output.

#include <concepts>
#include <type_traits>

namespace smaservo {

/// One instant as the observers see it; measure() makes it from a sample.
template <class S>
struct Measurement {
  S resistance_ohm;     ///< resistance of the wire alone
  S resistance_sd_ohm;  ///< standard deviation that the sensors' noise gives it
  S power_W;            ///< electrical power into the wire
  S stress_Pa;
  // A value that is not valid is not used.
  bool resistance_valid;  ///< there is enough current, and the value is in the wire's range
  bool power_valid;
  bool stress_valid;
};

enum class Health : unsigned char {
  good,
  searching,  ///< several hypotheses about the phases are still possible
  doubtful,   ///< the resistance contradicts the model
};

/// What an observer knows of the wire.
template <class S>
struct Estimate {
  S strain;     ///< elongation of the whole wire
  S strain_sd;  ///< standard deviation of its error as the observer estimates it
  S temperature_K;
  S martensite, r_phase;   ///< means over the whole wire
  S resistance_model_ohm;  ///< resistance that the model expects; NaN if the observer has no such
                           ///< model
  Health health;
};

/// A strain observer: a pure step from measurement to estimate. State is trivially copyable.
template <class O>
concept StrainObserver =
    std::is_trivially_copyable_v<typename O::State> &&
    requires(const typename O::Params& params, typename O::State& state,
             const typename O::State& now, const Measurement<typename O::Scalar>& measurement,
             typename O::Scalar number) {
      /// Starts with no knowledge but this first measurement, whose stress is valid, and a guess of
      /// the ambient temperature.
      { O::start(params, measurement, number) } -> std::same_as<typename O::State>;
      /// dt_s is the time since the last measurement, up to 20 ms; the measurement holds for this
      /// interval.
      { O::advance(params, state, measurement, number) } -> std::same_as<void>;
      { O::estimate(params, now) } -> std::same_as<Estimate<typename O::Scalar>>;
    };

}  // namespace smaservo
