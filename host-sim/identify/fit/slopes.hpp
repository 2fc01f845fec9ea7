#pragma once
// The dependence of the start and finish temperatures of a wire's transitions on stress, and their
// fall with stress, which physics forbids (Clausius-Clapeyron).

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "model/wire/wire.hpp"

namespace smaservo::identify {

/// The surfaces of a wire by the keys of their processes, "wire.m2a" and others.
template <class T>
std::vector<std::pair<std::string, Surface<T>>> surfaces(const Wire<T>& wire) {
  const ThreePhaseParams<T>& k = wire.kinetics;
  std::vector<std::pair<std::string, Surface<T>>> all{{"wire.m2a", k.m2a},
                                                      {"wire.a2m", first_surface(k.a2m_a2r)},
                                                      {"wire.a2r", second_surface(k.a2m_a2r)}};
  if (k.separate_r2a) {
    all.emplace_back("wire.r2a", k.r2a);
  }
  if (k.separate_r2m) {
    all.emplace_back("wire.r2m", k.r2m);
  }
  return all;
}

/// Whether the curves of a wire end sooner than paper 000's.
inline bool has_taper(const Wire<double>& wire) {
  return std::ranges::any_of(surfaces(wire), [](const auto& one) { return one.second.taper > 0; });
}
/// Whether the orders of its loops depend on each other.
inline bool has_loop_order(const Wire<double>& wire) {
  return std::abs(wire.kinetics.loop_odds - 1) > 0;
}

/// The slopes over stress of the start temperature at no stress and at `max_Pa`, and those of the
/// finish temperature, K/Pa. Both temperatures are polynomials of second order, so their slopes are
/// extreme at the ends of the range.
template <class T>
std::array<T, 4> slopes_K_Pa(const Surface<T>& s, double max_Pa) {
  const T to_end = T(2 * max_Pa);
  return {s.start_K[1], s.start_K[1] + to_end * s.start_K[2], s.finish_K[1],
          s.finish_K[1] + to_end * s.finish_K[2]};
}

/// The steepest fall of start or finish, in K/Pa; 0 if neither falls.
inline double steepest_fall_K_Pa(const Surface<double>& surface, double max_Pa) {
  constexpr double rounding_K_Pa = 1e-20;
  const double fall_K_Pa = -std::ranges::min(slopes_K_Pa(surface, max_Pa));
  return fall_K_Pa > rounding_K_Pa ? fall_K_Pa : 0;
}

}  // namespace smaservo::identify
