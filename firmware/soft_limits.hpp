#pragma once
// Limits that shape the power. None of them is a fault; each has its own reason.

#include <cmath>

#include "firmware/command.hpp"
#include "firmware/feed_forward.hpp"
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

/// The reasons of one step.
class LimitReasons {
 public:
  void add(LimitReason why) { bits_ |= 1U << static_cast<unsigned>(why); }
  std::uint32_t bits() const { return bits_; }

 private:
  std::uint32_t bits_ = 0;
};

/// The range that the power may have now.
template <class S>
class PowerRange {
 public:
  /// `duty` is the average so far. Cost: some 200 instructions, half of them for the strain.
  PowerRange(const Prepared<S>& p, const Known<S>& known, const S& ohm, const S& loss_W,
             const S& duty);

  /// The wanted power as far as it is allowed. The smallest of the limits gives the reason; the
  /// least current, which only keeps the resistance measurable, gives way to none of them but the
  /// current's own limit.
  S apply(const S& wanted_W, LimitReasons& reasons) const {
    if (most_W_ < wanted_W) {
      reasons.add(because_);
      return most_W_ < least_W_ ? least_W_ : most_W_;
    }
    if (wanted_W < least_W_) {
      reasons.add(LimitReason::least_current);
      return least_W_;
    }
    return wanted_W;
  }

 private:
  /// A wire comes to its limit of temperature or strain in this time, and is held there.
  static constexpr S approach_s = S(0.01);

  void most(LimitReason why, const S& power_W) {
    if (power_W < most_W_) {
      most_W_ = S(0) < power_W ? power_W : S(0);
      because_ = why;
    }
  }
  void limit_stress(const SoftLimits<S>& q, const S& stress_Pa, const S& loss_W);
  void limit_duty(const SoftLimits<S>& q, const S& duty, const S& greatest_W);

  S least_W_;
  S most_W_;
  LimitReason because_ = LimitReason::current;
};

template <class S>
PowerRange<S>::PowerRange(const Prepared<S>& p, const Known<S>& known, const S& ohm,
                          const S& loss_W, const S& duty)
    : least_W_(p.settings.limits.least_current_A * p.settings.limits.least_current_A * ohm),
      most_W_(p.settings.limits.current_A * p.settings.limits.current_A * ohm) {
  const SoftLimits<S>& q = p.settings.limits;
  const S greatest_W = most_W_;
  most(LimitReason::power, q.power_W);
  const S below_K = q.temperature_K - q.hot_spot_K - known.estimate.temperature_K;
  most(LimitReason::temperature,
       loss_W + p.observer.model.body.capacity_J_K * below_K / approach_s);
  const S shorter = q.least_strain - known.estimate.strain;
  most(LimitReason::strain,
       shorter < S(0) ? loss_W + FeedForward<S>::heat_J(p, known.filter, shorter) / approach_s
                      : S(0));
  limit_stress(q, known.filter.stress_Pa, loss_W);
  limit_duty(q, duty, greatest_W);
  if (std::isfinite(known.supply_V)) {
    most(LimitReason::supply, known.supply_V * known.supply_V / ohm);
  }
}

/// Contracting against a spring raises the stress: heat beyond the loss fades over the last 10 %.
template <class S>
void PowerRange<S>::limit_stress(const SoftLimits<S>& q, const S& stress_Pa, const S& loss_W) {
  const S room = S(10) * (q.stress_Pa - stress_Pa);
  if (room < q.stress_Pa) {
    const S share = room / q.stress_Pa;
    most(LimitReason::stress, share < S(0) ? S(0) : loss_W + share * (most_W_ - loss_W));
  }
}

/// The same over the last 5 % of the duty.
template <class S>
void PowerRange<S>::limit_duty(const SoftLimits<S>& q, const S& duty, const S& greatest_W) {
  const S room = S(20) * (q.duty - duty);
  if (room < q.duty) {
    most(LimitReason::duty, (room < S(0) ? S(0) : room) * greatest_W);
  }
}

}  // namespace smaservo
