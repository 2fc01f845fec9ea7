#pragma once
// The observer as an object: readings of current, voltage and load in, strain out. For a recording
// in one piece it gives the bits of `host-sim replay` with its default settings.
//
//   Estimator estimator{wire};
//   const auto now = estimator.update({.current_A = 0.17, .voltage_V = 3.9, .load_N = 0.68}, 1e-3);
//   // now.strain is the wire's elongation, now.strain_sd its standard deviation.

#include <cmath>
#include <limits>
#include <type_traits>

#include "model/units.hpp"
#include "model/wire/wire.hpp"
#include "observer/measurement.hpp"
#include "observer/multiple_model.hpp"
#include "observer/substepping.hpp"

namespace smaservo {

/// The measurement parameters of a good front end for this wire: noise of 1e-4 of the wire's
/// greatest current and of its voltage there, four wires, no resistance below 3 % of that current.
template <class S>
MeasurementParams<S> good_front_end(const Wire<S>& wire) {
  const S ohm = cold_resistance_ohm(wire);
  const S limit_A = wire.limits.current_A;
  return {wire.geometry.area_m2(),
          S(0),
          S(0),
          S(1e-4) * limit_A,
          S(1e-4) * limit_A * ohm,
          S(0),
          S(0.03) * limit_A,
          S(0.5) * ohm,
          S(2.0) * ohm};
}

/// Estimates strain, temperature and phases of one wire (000; observer/README.md). Trivially
/// copyable: a copy is a saved state. No heap, no exceptions. On a PC in double a reading costs
/// 0.3 us, twice as much while it searches for unknown phases, and the object takes 10 kB (5 kB in
/// float).
template <class S>
class Estimator {
 public:
  using Observer = Substepping<MultipleModelFilter<S>>;

  /// After a longer time without readings the estimator starts anew: a wire may have done anything.
  static constexpr S longest_gap_s = S(60);

  /// The first reading starts the estimator, in air of about `ambient_K`; an error of 20 K is
  /// allowed for, and 25 °C are assumed where it is NaN. `wire` is a wire as load_wire() gives it:
  /// its numbers are not checked again.
  explicit Estimator(const Wire<S>& wire, const S& ambient_K = S(room_K))
      : Estimator(wire, good_front_end(wire), kalman_tuning(wire.accuracy), ambient_K) {}
  /// For sensors that are known, and for another tuning.
  Estimator(const Wire<S>& wire, const MeasurementParams<S>& sensors, const KalmanTuning<S>& tuning,
            const S& ambient_K = S(room_K))
      : sensors_(sensors),
        params_{plant_params(wire), tuning},
        ambient_K_(known_or_room_K(ambient_K)) {}

  /// The estimate after a reading that was taken dt_s after the last one; the first reading's dt_s
  /// is not used. Any interval is allowed: one of more than 7.5 ms is divided into equal steps of
  /// about 5 ms, and one of more than longest_gap_s starts anew. A value that is NaN is not used,
  /// and neither is a resistance that this wire cannot have; the others are. Loads and powers are
  /// believed as they are: refuse what your sensors cannot mean before. All numbers are NaN, with
  /// Health::doubtful, until a reading has a load, and if dt_s is not greater than 0; such a
  /// reading is ignored.
  Estimate<S> update(const Sample<S>& reading, const S& dt_s) {
    using std::isfinite;
    if (started_ && !(S(0) < dt_s)) {
      return unknown();
    }
    measurement_ = measure(sensors_, reading);
    if (started_ && dt_s <= longest_gap_s) {
      Observer::advance(params_, state_, measurement_, dt_s);
    } else {
      started_ = measurement_.stress_valid;
      if (!started_) {
        return unknown();
      }
      Observer::start(params_, state_, measurement_, ambient_K_);
    }
    const Estimate<S> e = Observer::estimate(params_, state_);
    // NaN would never leave the observer: the next reading starts it anew.
    started_ = isfinite(e.strain + e.strain_sd + e.temperature_K);
    return started_ ? e : unknown();
  }

  /// Forgets all readings.
  void restart() { started_ = false; }
  /// Whether it has an estimate: there has been a reading with a load since the start, the last
  /// restart() and the last long gap.
  bool started() const { return started_; }

  /// Resistance, power and stress of the last reading.
  const Measurement<S>& measurement() const { return measurement_; }

  /// For those who call the functions of the observer themselves.
  const typename Observer::Params& params() const { return params_; }
  /// Likewise.
  const typename Observer::State& state() const { return state_; }

 private:
  static S known_or_room_K(const S& ambient_K) {
    using std::isfinite;
    return isfinite(ambient_K) ? ambient_K : S(room_K);
  }
  static Estimate<S> unknown() {
    constexpr S nan = std::numeric_limits<S>::quiet_NaN();
    return {nan, nan, nan, nan, nan, nan, Health::doubtful};
  }

  MeasurementParams<S> sensors_;
  typename Observer::Params params_;
  S ambient_K_;
  Measurement<S> measurement_{};
  bool started_ = false;
  typename Observer::State state_{};
};

static_assert(std::is_trivially_copyable_v<Estimator<double>>);

}  // namespace smaservo
