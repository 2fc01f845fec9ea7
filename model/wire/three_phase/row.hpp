#pragma once
// Many instances of one kind of kinetics side by side, as in the segments of a wire.

#include <array>
#include <cstddef>

#include "model/kinetics.hpp"

namespace smaservo {

/// Steps them one after the other. Kinetics that are faster when stepped together specialise it.
template <Kinetics K, std::size_t count>
struct Row {
  using S = typename K::Scalar;
  template <class T>
  using Each = std::array<T, count>;

  /// Data kept from step to step besides the states, for speed only: they change no result.
  struct Kept {};

  static Each<PhaseRates<S>> rates(const Each<typename K::Params>& p,
                                   const Each<typename K::State>& s, Kept& /*kept*/,
                                   const Each<Heading>& heading) {
    Each<PhaseRates<S>> rates;
    for (std::size_t i = 0; i < count; ++i) {
      rates[i] = K::rates(p[i], s[i], heading[i]);
    }
    return rates;
  }

  static void advance(const Each<typename K::Params>& p, Each<typename K::State>& s, Kept& /*kept*/,
                      const Each<S>& temperature_K, const S& stress_Pa) {
    for (std::size_t i = 0; i < count; ++i) {
      K::advance(p[i], s[i], {temperature_K[i], stress_Pa});
    }
  }
};

}  // namespace smaservo
