#include "host-sim/papers/figures/002/liang_rogers_002.hpp"

#include <limits>

namespace smaservo::figures::bench_002 {
namespace {

papers::CosineProcess<double> process(const Surface<double>& surface) {
  const double K_Pa = 0.5 * (surface.start_K[1] + surface.finish_K[1]);
  return {surface.start_K[0], surface.finish_K[0],
          K_Pa > 0 ? 1 / K_Pa : std::numeric_limits<double>::infinity()};
}

}  // namespace

papers::LiangRogers<double>::Params liang_rogers(const Wire<double>& wire) {
  return {process(wire.kinetics.m2a), process(first_surface(wire.kinetics.a2m_a2r)),
          process(second_surface(wire.kinetics.a2m_a2r))};
}

std::vector<papers::ResistancePoint<double>> liang_rogers_loop(const Wire<double>& wire,
                                                               double stress_Pa, bool heats) {
  using K = papers::LiangRogers<double>;
  constexpr double cold_K = 283.15;
  constexpr double hot_K = 423.15;
  constexpr int steps = 700;
  const K::Params params = liang_rogers(wire);
  K::State s = K::rest(params, {heats ? cold_K : hot_K, stress_Pa});
  std::vector<papers::ResistancePoint<double>> points;
  for (int i = 0; i <= steps; ++i) {
    const double share = static_cast<double>(i) / steps;
    const Drive<double> u{cold_K + (hot_K - cold_K) * (heats ? share : 1 - share), stress_Pa};
    K::advance(params, s, u);
    const double strain = papers::mixed_modulus_strain(wire.material, K::phases(s), stress_Pa);
    points.push_back({strain, resistance_ohm(resistivity(wire.material, K::phases(s), u).value,
                                             wire.length_per_area_1_m(), strain)});
  }
  return points;
}

}  // namespace smaservo::figures::bench_002
