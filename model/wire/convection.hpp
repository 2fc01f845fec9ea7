#pragma once
// Natural convection of a wire for loops: the formula of heat.hpp, with a table for the factors
// that depend on the film temperature, so that only one cheap root is left to compute.

#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <tuple>
#include <type_traits>

#include "model/wire/heat.hpp"

namespace smaservo {

/// x^(1/6) for x in 1e-37..1e37; smaller x count as 1e-37. Worst relative error: double 5e-12,
/// float 3e-7. Cost: 22 flops, 2 divisions, no call and no branch: a loop over it is vectorised.
template <class S>
S sixth_root(const S& x) {
  static_assert(std::is_floating_point_v<S>);
  const S a = x < S(1e-37) ? S(1e-37) : x;
  // A float's bits are nearly its logarithm; the constant spreads the error evenly, 3.4 %.
  const auto bits = std::bit_cast<std::uint32_t>(static_cast<float>(a));
  S y = static_cast<S>(std::bit_cast<float>(bits / 6 + 887'480'000U));
  // Halley's method cubes the error: y <- y (5 y⁶ + 7 x)/(7 y⁶ + 5 x)
  for (int i = 0; i < 2; ++i) {
    const S y3 = y * y * y;
    const S y6 = y3 * y3;
    y *= (S(5) * y6 + S(7) * a) / (S(7) * y6 + S(5) * a);
  }
  return y;
}

/// natural_convection_W_m2K() as h = k (0.60 + b (d³ |T - T_a|)^(1/6))²/d, with k and b, which
/// depend on the film temperature alone, as cubics in cells of 10 K.
template <class S>
class ConvectionTable {
 public:
  /// Builds the table. Cost: 2000 powers.
  ConvectionTable() {
    for (std::size_t i = 0; i < cells_.size(); ++i) {
      cells_[i] = cell(coldest_K + width_K * static_cast<double>(i));
    }
  }

  /// Relative error to natural_convection_W_m2K(): 1e-6 (float: 2e-6) in its whole range, and
  /// beyond it as long as the mean of the temperatures is 200..800 K. Cost for each temperature: 45
  /// flops, 2 divisions.
  template <std::size_t n>
  std::array<S, n> h_W_m2K(const S& diameter_m, const std::array<S, n>& temperature_K,
                           const S& ambient_K) const {
    using std::sqrt;
    const S per_m = S(1) / diameter_m;
    const S root_m = sqrt(diameter_m);
    std::array<S, n> h, still, moving;
    for (std::size_t k = 0; k < n; ++k) {
      const S at = (S(0.5) * (temperature_K[k] + ambient_K) - S(coldest_K)) * S(1 / width_K);
      const int i = index(at);
      const S x = at - static_cast<S>(i);
      const Cell& c = cells_[static_cast<std::size_t>(i)];
      still[k] = c.conductivity_W_mK.at(x) * per_m;
      moving[k] = c.root.at(x) * root_m;
    }
    // A separate loop, so that vector registers can be used.
    for (std::size_t k = 0; k < n; ++k) {
      const S difference_K = temperature_K[k] - ambient_K;
      const S apart_K = difference_K < S(0) ? -difference_K : difference_K;
      const S root = S(0.60) + moving[k] * sixth_root(apart_K);
      h[k] = still[k] * root * root;
    }
    return h;
  }
  S h_W_m2K(const S& diameter_m, const S& temperature_K, const S& ambient_K) const {
    return h_W_m2K(diameter_m, std::array<S, 1>{temperature_K}, ambient_K)[0];
  }

 private:
  static constexpr double coldest_K = 200;
  static constexpr double width_K = 10;

  struct Cubic {
    std::array<S, 4> c;
    S at(const S& x) const { return c[0] + x * (c[1] + x * (c[2] + x * c[3])); }
  };
  struct Cell {
    Cubic conductivity_W_mK;
    Cubic root;  ///< b
  };

  /// The index of the nearest cell; NaN gives the first one.
  static int index(const S& at) {
    const S last = static_cast<S>(std::tuple_size_v<decltype(cells_)> - 1);
    const S inside = S(0) < at ? (at < last ? at : last) : S(0);
    return static_cast<int>(inside);
  }

  static Cell cell(double from_K) {
    std::array<double, 4> k, b;
    for (std::size_t i = 0; i < 4; ++i) {
      const double film_K = from_K + width_K * node(i);
      // For a wire of 1 m diameter and a difference of 1 K, (d³ |T - T_a|)^(1/6) = 1.
      const double still = natural_convection_W_m2K(1.0, film_K, film_K);
      const double moving = natural_convection_W_m2K(1.0, film_K + 0.5, film_K - 0.5);
      k[i] = still / (0.60 * 0.60);
      b[i] = std::sqrt(moving / k[i]) - 0.60;
    }
    return {cubic(k), cubic(b)};
  }
  /// The i-th Chebyshev node, in 0..1
  static double node(std::size_t i) {
    constexpr std::array<double, 4> cosines{-0.92387953251128674, -0.38268343236508978,
                                            0.38268343236508978, 0.92387953251128674};
    return 0.5 + 0.5 * cosines[i];
  }
  /// The cubic through these values at the nodes, by Newton's divided differences.
  static Cubic cubic(std::array<double, 4> value) {
    for (std::size_t order = 1; order < 4; ++order) {
      for (std::size_t i = 3; i >= order; --i) {
        value[i] = (value[i] - value[i - 1]) / (node(i) - node(i - order));
      }
    }
    std::array<double, 4> c{value[3], 0, 0, 0};
    for (std::size_t k = 3; k-- > 0;) {  // c <- value[k] + (x - node) c
      for (std::size_t i = 3; i > 0; --i) {
        c[i] = c[i - 1] - node(k) * c[i];
      }
      c[0] = value[k] - node(k) * c[0];
    }
    return {
        {static_cast<S>(c[0]), static_cast<S>(c[1]), static_cast<S>(c[2]), static_cast<S>(c[3])}};
  }

  std::array<Cell, 60> cells_;
};

}  // namespace smaservo
