#pragma once
// One transformation along a cosine over temperature, and a branch of it: what the models after
// Liang and Rogers (1990) are made of. Source: 002 eq. 31 to 34.

#include <cmath>
#include <numbers>

#include "model/kinetics.hpp"

namespace smaservo::papers {

/// Start and finish at zero stress, with start_K != finish_K.
template <class S>
struct CosineProcess {
  S start_K;
  S finish_K;
  S stress_Pa_K;  ///< Clausius-Clapeyron slope C: a stress σ raises both temperatures by σ/C

  /// How far the drive is from start to finish, 0..1.
  constexpr S progress(const Drive<S>& u) const {
    const S x = (u.temperature_K - start_K - u.stress_Pa / stress_Pa_K) / (finish_K - start_K);
    return x < S(0) ? S(0) : S(1) < x ? S(1) : x;
  }
};

/// The share of its pool that a complete run has left at progress x: (cos(π x) + 1)/2 (002 eq. 31
/// and 33).
template <class S>
S cosine_left(const S& x) {
  using std::cos;
  return S(0.5) * cos(S(std::numbers::pi) * x) + S(0.5);
}

/// A run of a process through its pool, from the point where it began.
template <class S>
struct CosineBranch {
  S amplitude;  ///< pool at start; above 1 if the branch began between start and finish
  S progress;   ///< the farthest so far, 0..1

  /// A branch that begins at progress x with this pool.
  static CosineBranch at(const S& pool, const S& x) {
    const S remaining = cosine_left(x);
    return {S(0) < remaining ? pool / remaining : S(0), x};
  }

  /// The pool that is left when the branch advances to progress x; never more than before.
  S convert(const S& pool, const S& x) {
    progress = x;
    const S scaled = amplitude * cosine_left(x);
    return scaled < pool ? scaled : pool;
  }

  /// The slope of the pool over temperature at progress x.
  S pool_1_K(const CosineProcess<S>& process, const S& x) const {
    using std::sin;
    return S(-0.5 * std::numbers::pi) * amplitude * sin(S(std::numbers::pi) * x) /
           (process.finish_K - process.start_K);
  }
};

}  // namespace smaservo::papers
