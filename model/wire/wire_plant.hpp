#pragma once
// A wire as an object that a program simulates: current and load in, strain, resistance and
// temperature out. It has the three-phase model and one temperature (plant.hpp, whose functions
// this class calls in the right order).
//
//   WirePlant plant{wire};
//   const auto now = plant.update({.current_A = 0.17, .load_N = 0.68}, 1e-3);

#include <cmath>
#include <limits>
#include <type_traits>

#include "model/units.hpp"
#include "model/wire/plant.hpp"
#include "model/wire/three_phase/three_phase.hpp"

namespace smaservo {

/// What acts on a wire during one step.
template <class S>
struct WireInput {
  S current_A = S(0);
  S load_N = S(0);
  S ambient_K = S(room_K);
  S draught = S(1);  ///< factor on the heat loss of still air, greater than 0
};

/// A wire after a step. All are NaN after a step that was not made.
template <class S>
struct WireOutput {
  S strain;          ///< elongation of the whole wire: greatest in cold martensite
  S resistance_ohm;  ///< of the wire alone
  S temperature_K;   ///< of the wire without the ends that the clamps cool
  S martensite;      ///< mean fraction over the whole wire, 0 to 1
  S r_phase;         ///< likewise; austenite is the rest
};

/// Trivially copyable: a copy is a saved state. No heap, no exceptions. On a PC in double a step
/// costs 0.2 us, and the object takes 1.7 kB.
template <class S>
class WirePlant {
 public:
  using Model = Plant<ThreePhase<S>>;

  /// update() divides dt_s into equal parts of at most this.
  static constexpr S longest_step_s = S(5e-3);
  /// update() refuses a longer dt_s.
  static constexpr S longest_update_s = S(60);

  /// The wire rests at this ambient temperature under this load, cooled from far above; both are
  /// finite, and the temperature is above 0. `wire` is a wire as load_wire() gives it: its numbers
  /// are not checked again.
  explicit WirePlant(const Wire<S>& wire, const S& load_N = S(0), const S& ambient_K = S(room_K))
      : area_m2_(wire.geometry.area_m2()), params_(plant_params(wire)), still_(params_.body) {
    // A wire reverses after any change of temperature; only an observer needs a threshold, because
    // of noise.
    params_.kinetics.smallest_reversal_K = S(0);
    rest(load_N, ambient_K);
  }

  /// Puts the wire at rest, cooled from far above, as the constructor does.
  void rest(const S& load_N, const S& ambient_K) {
    ambient_K_ = ambient_K;
    state_ = Model::rest(params_, {ambient_K, load_N / area_m2_});
  }

  /// Lets the input act for dt_s, greater than 0 and up to a minute. The current heats the
  /// resistance that the wire has at the beginning of a step. A step is not made, and its output is
  /// NaN, if a number of the input is not finite, if draught or dt_s is out of its range, or if the
  /// result would not be finite; the wire then stays as it was.
  WireOutput<S> update(const WireInput<S>& in, const S& dt_s) {
    WirePlant next = *this;
    if (!next.advance(in, dt_s)) {
      constexpr S nan = std::numeric_limits<S>::quiet_NaN();
      return {nan, nan, nan, nan, nan};
    }
    *this = next;
    return output();
  }

  /// What update() would give; the wire does not change. For a load that depends on the strain,
  /// such as a spring's or another wire's, the load of a step is sought with this.
  WireOutput<S> after(const WireInput<S>& in, const S& dt_s) const {
    WirePlant trial = *this;
    return trial.update(in, dt_s);
  }

  /// The wire as it is now.
  WireOutput<S> output() const {
    const Phases<S> z = params_.ends.average(Model::phases(state_));
    return {Model::strain(params_, state_), Model::resistance_ohm(params_, state_, ambient_K_),
            Model::temperature_K(state_), z.martensite, z.r_phase};
  }

  /// For those who call the functions of Plant themselves.
  const typename Model::Params& params() const { return params_; }
  /// Likewise.
  const typename Model::State& state() const { return state_; }

 private:
  bool advance(const WireInput<S>& in, const S& dt_s) {
    using std::ceil;
    using std::isfinite;
    if (!(S(0) < dt_s && dt_s <= longest_update_s && S(0) < in.draught && S(0) < in.ambient_K &&
          isfinite(in.draught + in.ambient_K + in.load_N + in.current_A))) {
      return false;
    }
    params_.body.loss_W_K = in.draught * still_.loss_W_K;
    params_.body.loss_W_K2 = in.draught * still_.loss_W_K2;
    ambient_K_ = in.ambient_K;
    const int steps = static_cast<int>(ceil(dt_s / longest_step_s));
    for (int i = 0; i < steps; ++i) {
      const S ohm = Model::resistance_ohm(params_, state_, ambient_K_);
      Model::advance(params_, state_,
                     {in.current_A * in.current_A * ohm, in.load_N / area_m2_, ambient_K_},
                     dt_s / S(steps));
    }
    const WireOutput<S> out = output();
    return isfinite(out.strain + out.resistance_ohm + out.temperature_K + out.martensite +
                    out.r_phase);
  }

  S area_m2_;
  typename Model::Params params_;
  ThermalBody<S> still_;
  S ambient_K_ = S(room_K);
  typename Model::State state_;
};

static_assert(std::is_trivially_copyable_v<WirePlant<double>>);

}  // namespace smaservo
