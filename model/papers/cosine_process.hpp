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
  S stress_Pa_K;  ///< Clausius-Clapeyron slope C, by which stress raises both temperatures

  /// How far the drive is from start to finish, 0..1.
  constexpr S progress(const Drive<S>& u) const {
    const S x = (u.temperature_K - start_K - u.stress_Pa / stress_Pa_K) / (finish_K - start_K);
    return x < S(0) ? S(0) : S(1) < x ? S(1) : x;
  }
};

/// What a complete run has left of its pool: (cos(π x) + 1)/2 (002 eq. 31 and 33).
template <class S>
S cosine_left(const S& x) {
  using std::cos;
  return S(0.5) * cos(S(std::numbers::pi) * x) + S(0.5);
}

/// A run of a process through its pool, from wherever it began.
template <class S>
struct CosineBranch {
  S amplitude;  ///< what it converts from start to finish; above 1 when it began between
  S progress;   ///< the farthest

  /// Begins here with this pool.
  static CosineBranch at(const S& pool, const S& x) {
    const S remaining = cosine_left(x);
    return {S(0) < remaining ? pool / remaining : S(0), x};
  }

  /// What is left of the pool when the branch goes on to x; never more than before.
  S convert(const S& pool, const S& x) {
    progress = x;
    const S scaled = amplitude * cosine_left(x);
    return scaled < pool ? scaled : pool;
  }

  /// Slope of the pool at x.
  S pool_1_K(const CosineProcess<S>& process, const S& x) const {
    using std::sin;
    return S(-0.5 * std::numbers::pi) * amplitude * sin(S(std::numbers::pi) * x) /
           (process.finish_K - process.start_K);
  }
};

}  // namespace smaservo::papers
