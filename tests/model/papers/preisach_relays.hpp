#pragma once
// A Preisach model that several tests share.

#include <cmath>
#include <cstddef>

#include "model/papers/preisach.hpp"

namespace smaservo::test {

inline double logistic(double x) {
  return 1 / (1 + std::exp(-x));
}

/// Relays about as wide as those of the 76 um wire, wider the greater the stress.
template <class S>
papers::PreisachParams<S> relays(double shift_K_MPa) {
  papers::PreisachParams<S> p{};
  constexpr std::size_t nodes = 24;
  const auto node_K = [](std::size_t i) { return 288 + 4.25 * static_cast<double>(i); };
  for (std::size_t i = 0; i < nodes; ++i) {
    p.node_K[i] = static_cast<S>(node_K(i));
  }
  p.shift_K_Pa = static_cast<S>(1e-6 * shift_K_MPa);
  p.stress_count = 6;
  for (std::size_t k = 0; k < p.stress_count; ++k) {
    p.stress_Pa[k] = static_cast<S>(100e6 * static_cast<double>(k));
    // 003's form: without a shift of the input the distribution itself moves.
    const double moved_K = shift_K_MPa > 0 ? 0 : 8.0 * static_cast<double>(k);
    const double scale_K = 2.5 + 0.3 * static_cast<double>(k);
    const auto share = [&](std::size_t cell, double centre_K) {
      return logistic((node_K(cell + 1) - centre_K) / scale_K) -
             logistic((node_K(cell) - centre_K) / scale_K);
    };
    const auto weight = [&](std::size_t hot, std::size_t cold) {
      return share(hot, 345 + moved_K) * share(cold, 313 + moved_K) * (hot == cold ? 0.5 : 1);
    };
    const auto triangle = [&](std::size_t hot, std::size_t cold) {
      double sum = 0;
      for (std::size_t i = cold; i < hot; ++i) {
        for (std::size_t j = cold; j <= i; ++j) {
          sum += weight(i, j);
        }
      }
      return sum;
    };
    const double all = triangle(nodes - 1, 0);
    for (std::size_t hot = 1; hot < nodes; ++hot) {
      for (std::size_t cold = 0; cold < hot; ++cold) {
        p.increments[k][p.index(hot, cold)] = static_cast<S>(triangle(hot, cold) / all);
      }
    }
  }
  return p;
}

}  // namespace smaservo::test
