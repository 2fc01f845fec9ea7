#pragma once
// One full cycle at constant stress, as paper 000 measured it: oil bath, 20 to 150 degC.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "model/units.hpp"
#include "tests/model/wire/test_wires.hpp"

namespace smaservo::test {

struct LoopPoint {
  double temperature_K, strain, resistance;  ///< resistance of 1 m/m²: resistivity (1 + 2 strain)
  Phases<double> phases;
};

struct Loop {
  std::vector<LoopPoint> heating, cooling;

  double stroke() const {
    const auto by_strain = [](const LoopPoint& a, const LoopPoint& b) {
      return a.strain < b.strain;
    };
    const auto [low, high] = std::ranges::minmax_element(heating, by_strain);
    return high->strain - low->strain;
  }
};

inline Loop full_loop(const ThreePhase<double>::Params& kinetics, const Material<double>& material,
                      double stress_Pa) {
  using K = ThreePhase<double>;
  constexpr int steps = 2600;
  const auto temperature_K = [](int i) { return zero_degC_K + 20 + 130.0 * i / steps; };
  K::State s = K::rest(kinetics, {temperature_K(0), stress_Pa});
  Loop loop;
  const auto visit = [&](int i, std::vector<LoopPoint>& branch) {
    const Drive<double> u{temperature_K(i), stress_Pa};
    K::advance(kinetics, s, u);
    const Phases<double> z = K::phases(s);
    const double epsilon = strain(material, z, stress_Pa);
    branch.push_back({u.temperature_K, epsilon,
                      resistance_ohm(resistivity(material, z, u).value, 1.0, epsilon), z});
  };
  // The first cycle brings the wire onto the loop.
  for (int cycle = 0; cycle < 2; ++cycle) {
    loop = {};
    for (int i = 0; i <= steps; ++i) {
      visit(i, loop.heating);
    }
    for (int i = steps; i >= 0; --i) {
      visit(i, loop.cooling);
    }
  }
  return loop;
}

/// Strain differences of a point to the points of a branch with the same resistance: the least.
inline double nearest_strain_gap(const LoopPoint& point, const std::vector<LoopPoint>& branch) {
  double min = std::numeric_limits<double>::infinity();
  for (std::size_t i = 1; i < branch.size(); ++i) {
    const LoopPoint& a = branch[i - 1];
    const LoopPoint& b = branch[i];
    if ((a.resistance - point.resistance) * (b.resistance - point.resistance) <= 0) {
      const double span = b.resistance - a.resistance;
      const double share = span == 0 ? 0 : (point.resistance - a.resistance) / span;
      min = std::min(min, std::abs(a.strain + share * (b.strain - a.strain) - point.strain));
    }
  }
  return min;
}

/// Greatest strain difference between heating and cooling at equal resistance, in % of stroke,
/// where both pass through that resistance.
inline double hysteresis_percent(const Loop& loop) {
  double worst = 0;
  const auto compare = [&](const std::vector<LoopPoint>& a, const std::vector<LoopPoint>& b) {
    for (std::size_t i = 0; i < a.size(); i += 4) {
      const double gap = nearest_strain_gap(a[i], b);
      worst = std::isfinite(gap) ? std::max(worst, gap) : worst;
    }
  };
  compare(loop.heating, loop.cooling);
  compare(loop.cooling, loop.heating);
  return 100 * worst / loop.stroke();
}

/// Greatest deviation of strain from the best straight line over resistance, in % of stroke; every
/// bit of strain counts the same, whatever temperature it takes.
inline double curvature_percent(const Loop& loop) {
  double w = 0, x = 0, y = 0, xx = 0, xy = 0;
  const auto each = [&](auto visit) {
    for (const auto* branch : {&loop.heating, &loop.cooling}) {
      for (std::size_t i = 1; i < branch->size(); ++i) {
        visit((*branch)[i], std::abs((*branch)[i].strain - (*branch)[i - 1].strain));
      }
    }
  };
  each([&](const LoopPoint& p, double weight) {
    w += weight;
    x += weight * p.resistance;
    y += weight * p.strain;
  });
  each([&](const LoopPoint& p, double weight) {
    xx += weight * (p.resistance - x / w) * (p.resistance - x / w);
    xy += weight * (p.resistance - x / w) * (p.strain - y / w);
  });
  double worst = 0;
  each([&](const LoopPoint& p, double) {
    worst = std::max(worst, std::abs(p.strain - y / w - xy / xx * (p.resistance - x / w)));
  });
  return 100 * worst / loop.stroke();
}

}  // namespace smaservo::test
