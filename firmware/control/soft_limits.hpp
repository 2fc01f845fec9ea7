#pragma once
// Limits that shape the power. None of them is a fault; each reports its own LimitReason.

#include <limits>

#include "firmware/command.hpp"
#include "firmware/control/feed_forward.hpp"
#include "firmware/prepared.hpp"
#include "model/scalar/scalar.hpp"

namespace smaservo {

/// The controller's knowledge of the wire in one step.
template <class S>
struct ControlInputs {
  const Measurement<S>& measurement;
  const Estimate<S>& estimate;
  /// The most likely filter's state: model, ambient, loss.
  const typename KalmanObserver<S>::State& filter;
  S current_A;
  S supply_V;  ///< supply voltage; NaN if not measured
  /// Temperature of the air; NaN if not measured.
  S ambient_K = std::numeric_limits<S>::quiet_NaN();
  S hot_K = S(0);      ///< wire temperature by HotResistance; 0: not known
  S weak_K = S(0);     ///< wire temperature by CoolingGuard; 0: not known
  bool probe = false;  ///< the cooling is being tested, which needs zero power
};

/// The limit reasons of one step.
class LimitReasons {
 public:
  void add(LimitReason why) { bits_ |= 1U << static_cast<unsigned>(why); }
  std::uint32_t bits() const { return bits_; }

 private:
  std::uint32_t bits_ = 0;
};

/// The range that the power must stay within in this step.
template <class S>
class PowerRange {
 public:
  /// `duty` is the averaged square of the current as a share of its limit so far, `sustained_W` the
  /// power averaged over the wire's thermal time constant. Cost: 70 flops, 8 divisions.
  PowerRange(const Prepared<S>& p, const ControlInputs<S>& known, const S& ohm, const S& loss_W,
             const S& duty, const S& sustained_W, const S& dt_s);

  /// Clamps the wanted power to the range. If that changes it, the reason is added; above the
  /// range, the reason of the smallest limit. NaN becomes the least power.
  S apply(const S& wanted_W, LimitReasons& reasons) const {
    if (max_W_ < wanted_W) {
      reasons.add(because_);
    } else if (!(min_W_ <= wanted_W)) {
      reasons.add(LimitReason::min_current);
    }
    return within(wanted_W);
  }
  /// Like apply(), but without adding a reason.
  S within(const S& wanted_W) const {
    const S bounded = max_W_ < wanted_W ? max_W_ : wanted_W;
    return min_W_ <= bounded ? bounded : min_W_;
  }

 private:
  /// Time constant with which a wire may approach its limit of temperature or strain, where it is
  /// then held.
  static constexpr S approach_s = S(0.01);
  /// HotResistance limits the power only above the limit plus this margin. A wire that cools a
  /// little from its limit begins to transform, which raises its resistance. Without the margin it
  /// would be taken for a hotter one and be cooled further, through its whole hysteresis, again and
  /// again.
  static constexpr S hot_margin_K = S(1.5);

  void max(LimitReason why, const S& power_W) {
    if (power_W < max_W_) {
      max_W_ = S(0) < power_W ? power_W : S(0);
      because_ = why;
    }
  }
  void limit_sustained(const Prepared<S>& p, const ControlInputs<S>& known, const S& sustained_W);
  void limit_strain(const Prepared<S>& p, const ControlInputs<S>& known, const S& loss_W,
                    const S& dt_s);
  void limit_stress(const SoftLimits<S>& q, const S& stress_Pa, const S& loss_W);
  void limit_duty(const SoftLimits<S>& q, const S& duty, const S& max_W);

  /// Power of the minimum current, which other limits do not reduce: without it the resistance
  /// cannot be measured, and the estimate that the limits need is lost. parameter_check.hpp limits
  /// its heating effect. Only limits.current_A and limits.power_W may be lower.
  S min_W_;
  S max_W_;
  LimitReason because_ = LimitReason::current;
};

template <class S>
PowerRange<S>::PowerRange(const Prepared<S>& p, const ControlInputs<S>& known, const S& ohm,
                          const S& loss_W, const S& duty, const S& sustained_W, const S& dt_s)
    : min_W_(p.settings.limits.min_current_A * p.settings.limits.min_current_A * ohm),
      max_W_(p.settings.limits.current_A * p.settings.limits.current_A * ohm) {
  const SoftLimits<S>& q = p.settings.limits;
  const S max_W = max_W_;
  max(LimitReason::power, q.power_W);
  min_W_ = max_W_ < min_W_ ? max_W_ : min_W_;
  const S hot_K = known.hot_K - hot_margin_K;
  const S wire_K = known.estimate.temperature_K < hot_K ? hot_K : known.estimate.temperature_K;
  const S hottest_K = wire_K < known.weak_K ? known.weak_K : wire_K;
  const S below_K = q.temperature_K - q.hot_spot_K - hottest_K;
  max(LimitReason::temperature,
      loss_W +
          FeedForward<S>::power_W(p.observer.model.body.capacity_J_K * below_K, approach_s, dt_s));
  limit_sustained(p, known, sustained_W);
  if (known.probe) {
    max(LimitReason::temperature, S(0));
  }
  if (isfinite(known.supply_V)) {
    max(LimitReason::supply, known.supply_V * known.supply_V / ohm);
  }
  limit_duty(q, duty, max_W);
  limit_strain(p, known, loss_W, dt_s);
  // The measured stress is used, since the filtered one lags by more time than a wire needs to
  // contract.
  limit_stress(
      q, known.measurement.stress_valid ? known.measurement.stress_Pa : known.filter.stress_Pa,
      loss_W);
}

/// Bounds the average power by the wire file alone. A wire held at its temperature limit gives the
/// observer little information: a resistance error of 0.3 % is mistaken for stronger cooling, so
/// the allowed power would rise without end.
template <class S>
void PowerRange<S>::limit_sustained(const Prepared<S>& p, const ControlInputs<S>& known,
                                    const S& sustained_W) {
  const SoftLimits<S>& q = p.settings.limits;
  const S believed_K = known.filter.ambient_K < known.filter.start_ambient_K
                           ? known.filter.start_ambient_K
                           : known.filter.ambient_K;
  const S air_K = believed_K < known.ambient_K ? known.ambient_K : believed_K;
  const S max_for_long_W =
      q.loss_margin * p.observer.model.body.loss_W(q.temperature_K - q.hot_spot_K - air_K);
  max(LimitReason::temperature, max_for_long_W + S(10) * (max_for_long_W - sustained_W));
}

/// Below the limit (room > 0) the wire gets at most the latent heat of the remaining strain, which
/// is less than it needs to contract by that strain. Beyond the limit the power falls within 0.1 %
/// of strain from the power that holds the temperature to zero. If it fell at once, a wire at the
/// limit would cool through its whole hysteresis and be heated up again.
template <class S>
void PowerRange<S>::limit_strain(const Prepared<S>& p, const ControlInputs<S>& known,
                                 const S& loss_W, const S& dt_s) {
  const auto& model = p.observer.model;
  const S room = known.estimate.strain - p.settings.limits.min_strain;
  if (S(0) < room) {
    const S by_m = strain_slopes(model.material, known.filter.stress_Pa).martensite;
    max(LimitReason::strain,
        loss_W + FeedForward<S>::power_W(model.body.latent_m2a_J * room / by_m, approach_s, dt_s));
  } else {
    max(LimitReason::strain, loss_W * (S(1) + S(1000) * room));
  }
}

/// Contracting against a spring raises the stress. Over the last 10 % below the limit the power is
/// reduced to that which holds the temperature, over the first 1 % above it to zero.
template <class S>
void PowerRange<S>::limit_stress(const SoftLimits<S>& q, const S& stress_Pa, const S& loss_W) {
  const S room = S(10) * (q.stress_Pa - stress_Pa);
  if (room < q.stress_Pa) {
    const S share = room / q.stress_Pa;
    max(LimitReason::stress,
        share < S(0) ? loss_W * (S(1) + S(10) * share) : loss_W + share * (max_W_ - loss_W));
  }
}

/// Over the last 5 % below limits.duty the greatest power falls from the share limits.duty to zero.
/// A limits.duty of 1 limits nothing: it allows the whole current all the time.
template <class S>
void PowerRange<S>::limit_duty(const SoftLimits<S>& q, const S& duty, const S& max_W) {
  const S room = S(20) * (q.duty - duty);
  if (room < q.duty && q.duty < S(1)) {
    max(LimitReason::duty, (room < S(0) ? S(0) : room) * max_W);
  }
}

}  // namespace smaservo
