#pragma once
// An observer for slow or irregular samples: it makes several steps from one sample to the next,
// with measurements interpolated linearly between them. A wire heats by 3 K in the 10 ms of a 100
// Hz trace, which is too much for one linearised step.

#include <cmath>

#include "observer/estimate.hpp"

namespace smaservo {

/// The observer O with steps of any length.
template <StrainObserver O>
struct Substepping {
  using Scalar = typename O::Scalar;
  using Params = typename O::Params;
  using S = Scalar;

  /// O's state and the last measurement.
  struct State {
    typename O::State observer;
    Measurement<S> last;
  };

  static constexpr S longest_step_s = S(5e-3);
  /// An interval is divided into at most this many substeps.
  static constexpr int max_substeps = 65536;

  /// As O's.
  static State start(const Params& p, const Measurement<S>& m, const S& ambient_K) {
    return {O::start(p, m, ambient_K), m};
  }
  /// Like start() above, but in place if the observer supports it.
  static void start(const Params& p, State& s, const Measurement<S>& m, const S& ambient_K) {
    O::start(p, s.observer, m, ambient_K);
    s.last = m;
  }

  /// dt_s up to a minute. Cost: one step of the observer for each 5 ms.
  static void advance(const Params& p, State& s, const Measurement<S>& m, const S& dt_s) {
    using std::ceil;
    // Rounding down by up to half a step keeps a clock that jitters around the longest step from
    // doubling the work.
    const S wanted = ceil(dt_s / longest_step_s - S(0.5));
    const int substeps = wanted < S(1)              ? 1
                         : wanted < S(max_substeps) ? static_cast<int>(wanted)
                                                    : max_substeps;
    const S substep_s = dt_s / S(substeps);
    for (int i = 1; i < substeps; ++i) {
      O::advance(p, s.observer, between(s.last, m, S(i) / S(substeps)), substep_s);
    }
    O::advance(p, s.observer, m, substep_s);
    s.last = m;
  }

  /// As O's.
  static Estimate<S> estimate(const Params& p, const State& s) {
    return O::estimate(p, s.observer);
  }

 private:
  /// A value that is valid at one end only is not valid in between: power is 0 then, the others are
  /// unused.
  static Measurement<S> between(const Measurement<S>& a, const Measurement<S>& b, const S& share) {
    const auto at = [&](const S& from, const S& to) { return from + share * (to - from); };
    Measurement<S> m{};
    m.resistance_valid = a.resistance_valid && b.resistance_valid;
    m.power_valid = a.power_valid && b.power_valid;
    m.stress_valid = a.stress_valid && b.stress_valid;
    if (m.resistance_valid) {
      m.resistance_ohm = at(a.resistance_ohm, b.resistance_ohm);
      m.resistance_sd_ohm = at(a.resistance_sd_ohm, b.resistance_sd_ohm);
    }
    if (m.power_valid) {
      m.power_W = at(a.power_W, b.power_W);
    }
    if (m.stress_valid) {
      m.stress_Pa = at(a.stress_Pa, b.stress_Pa);
    }
    return m;
  }
};

}  // namespace smaservo
