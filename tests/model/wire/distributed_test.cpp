#include "model/wire/distributed.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <gtest/gtest.h>

#include "model/plants/sublayers.hpp"
#include "model/wire/plant.hpp"
#include "tests/model/wire/test_wires.hpp"

namespace smaservo::test::distributed_test {
namespace {

constexpr double ambient_K = room_K;
constexpr std::size_t segments = 24;
using Lumped = Plant<ThreePhase<double>>;
using Divided = DistributedPlant<ThreePhase<double>, segments>;

template <class Distributed>
typename Distributed::Params divided(const auto& kinetics, std::size_t count) {
  const Wire<double>& wire = paper_wire();
  typename Distributed::Params p{};
  p.kinetics.fill(kinetics);
  p.material = wire.material;
  p.heat = wire.heat;
  p.geometry = wire.geometry;
  p.length_m.fill(wire.geometry.length_m / static_cast<double>(count));
  return p;
}

double current_A(double time_s) {
  const double t = std::fmod(time_s, 4.0);
  return t < 1 ? 0.13 : t < 1.5 ? 0.05 : t < 2 ? 0.11 : 0.02;
}

TEST(DistributedPlant, WithoutConductionIsTheLumpedPlantInEverySegment) {
  Divided::Params p = divided<Divided>(paper_wire().kinetics, segments);
  p.heat.clamp_conductivity_W_mK = 0;
  Lumped::Params q = plant_params(paper_wire());
  q.ends.share = 0;
  const double stress_Pa = 150e6;
  const double dt_s = 2e-4;
  Divided::State d = Divided::rest(p, {ambient_K, stress_Pa});
  Lumped::State s = Lumped::rest(q, {ambient_K, stress_Pa});
  double hottest_K = 0;
  for (int i = 0; i < 40000; ++i) {
    const double T = Lumped::temperature_K(s);
    // The convection that the distributed plant takes at the step's start
    q.body.loss_W_K = paper_wire().geometry.surface_m2() *
                      natural_convection_W_m2K(paper_wire().geometry.diameter_m, T, ambient_K);
    q.body.loss_W_K2 = 0;
    const double current = current_A(i * dt_s);
    const double power = current * current * Lumped::resistance_ohm(q, s, ambient_K);
    Lumped::advance(q, s, {power, stress_Pa, ambient_K}, dt_s);
    Divided::advance(p, d, current, {stress_Pa, ambient_K}, 1.0, dt_s);
    hottest_K = std::max(hottest_K, T);
    ASSERT_NEAR(Divided::temperature_K(d, 0), Lumped::temperature_K(s), 1e-7) << i;
    ASSERT_NEAR(Divided::temperature_K(d, segments - 1), Lumped::temperature_K(s), 1e-7) << i;
    ASSERT_NEAR(Divided::strain(p, d), Lumped::strain(q, s), 1e-9) << i;
    ASSERT_NEAR(Divided::resistance_ohm(p, d), Lumped::resistance_ohm(q, s, ambient_K), 1e-7) << i;
  }
  EXPECT_GT(hottest_K, 365);
}

/// Heat in minus losses is what is stored, over two cycles.
template <class K>
void expect_closed_balance(const typename DistributedPlant<K, segments>::Params& p) {
  using Plant = DistributedPlant<K, segments>;
  const double area_m2 = p.geometry.area_m2();
  const double dt_s = 1e-3;
  typename Plant::State s = Plant::rest(p, {ambient_K, 100e6});
  const auto stored_J = [&] {
    double sum = 0;
    for (std::size_t i = 0; i < segments; ++i) {
      const double mass_kg = p.heat.density_kg_m3 * area_m2 * p.length_m[i];
      const double above_K = Plant::temperature_K(s, i) - room_K;
      const Phases<double> z = K::phases(s.kinetics[i]);
      sum += s.heat_J[i] +
             mass_kg *
                 (p.heat.specific_heat_J_kgK * above_K * (1 + 0.5 * p.specific_heat_1_K * above_K) -
                  p.heat.latent_m2a_J_kg * z.martensite - p.heat.latent_r2a_J_kg * z.r_phase);
    }
    return sum;
  };
  const double before_J = stored_J();
  double in_J = 0;
  double out_J = 0;
  double through_clamps_J = 0;
  for (int k = 0; k < 8000; ++k) {
    const double current = current_A(k * dt_s);
    in_J += current * current * Plant::resistance_ohm(p, s) * dt_s;
    std::array<double, segments> loss_J_K{};
    for (std::size_t i = 0; i < segments; ++i) {
      loss_J_K[i] =
          dt_s * p.geometry.surface_m2() * p.length_m[i] / p.geometry.length_m *
          p.convection.h_W_m2K(p.geometry.diameter_m, Plant::temperature_K(s, i), ambient_K);
    }
    Plant::advance(p, s, current, {100e6, ambient_K}, 1.0, dt_s);
    for (std::size_t i = 0; i < segments; ++i) {
      out_J += loss_J_K[i] * (Plant::temperature_K(s, i) - ambient_K);
    }
    for (const std::size_t end : {std::size_t{0}, segments - 1}) {
      through_clamps_J += dt_s * p.heat.clamp_conductivity_W_mK * area_m2 /
                          (0.5 * p.length_m[end]) * (Plant::temperature_K(s, end) - ambient_K);
    }
  }
  EXPECT_GT(in_J, 0.5);
  EXPECT_GT(through_clamps_J, 0.005 * in_J);
  EXPECT_NEAR(stored_J() - before_J, in_J - out_J - through_clamps_J, 1e-10 * in_J);
}

TEST(DistributedPlant, HeatInMinusLossesIsWhatIsStored) {
  expect_closed_balance<ThreePhase<double>>(divided<Divided>(paper_wire().kinetics, segments));
}

TEST(DistributedPlant, HeatInMinusLossesIsWhatIsStoredWhenTheHeatCapacityRises) {
  using K = Sublayers<double>;
  auto p = divided<DistributedPlant<K, segments>>(K::params({{347, 6, 3, 1.3e-7, 0},
                                                             {313, 8, 3, 1.4e-7, 0},
                                                             {344, 6, 3, 1.3e-7, 0},
                                                             {333, 8, 3, 0, 0},
                                                             0.6,
                                                             -0.6,
                                                             1.5,
                                                             1}),
                                                  segments);
  p.specific_heat_1_K = 1e-3;
  p.parallel_share = 0.5;
  expect_closed_balance<K>(p);
}

/// What is left of one step's heat, as a share of what came in, when nothing is curved in it.
template <std::size_t count>
double left_of_a_linear_step() {
  using Plant = DistributedPlant<papers::Cosine<double>, count>;
  const Wire<double>& wire = paper_wire();
  typename Plant::Params p{};
  p.kinetics.fill({{600, 610, 1e7}, {590, 580, 1e7}});
  p.material = wire.material;
  p.heat = wire.heat;
  p.geometry = {0.012, wire.geometry.diameter_m};
  for (std::size_t i = 0; i < count; ++i) {
    p.length_m[i] = 0.012 * static_cast<double>(2 * (i + 1)) / (count * (count + 1));
  }
  typename Plant::State s = Plant::rest(p, {ambient_K, 100e6});
  double worst = 0;
  for (int i = 0; i < 1000; ++i) {
    const double in_J = 0.08 * 0.08 * Plant::resistance_ohm(p, s) * 1e-3;
    Plant::advance(p, s, 0.08, {100e6, ambient_K}, 1.0, 1e-3);
    for (const double left_J : s.heat_J) {
      worst = std::max(worst, std::abs(left_J) / in_J);
    }
  }
  EXPECT_GT(Plant::temperature_K(s, count / 2), ambient_K + 10);
  return worst;
}

TEST(DistributedPlant, ALinearStepIsSolvedForAnyNumberOfSegments) {
  for (const double left : {left_of_a_linear_step<2>(), left_of_a_linear_step<3>(),
                            left_of_a_linear_step<7>(), left_of_a_linear_step<24>()}) {
    EXPECT_LT(left, 1e-10);
  }
}

TEST(DistributedPlant, ParallelShareGoesFromSeriesToParallel) {
  Divided::Params p = divided<Divided>(paper_wire().kinetics, segments);
  const Divided::State s = Divided::rest(p, {325, 50e6});
  const double series = Divided::resistance_ohm(p, s);
  p.material.mixture = Mixture::parallel;
  const double parallel = Divided::resistance_ohm(p, s);
  EXPECT_LT(parallel, 0.9995 * series);
  p.parallel_share = 1;
  EXPECT_NEAR(Divided::resistance_ohm(p, s), parallel, 1e-12 * series);
  p.parallel_share = 0.25;
  EXPECT_NEAR(Divided::resistance_ohm(p, s), series + 0.25 * (parallel - series), 1e-12 * series);
}

TEST(DistributedPlant, SteadyTemperatureBetweenClampsIsTheFinProfile) {
  // Martensite throughout and a resistivity that knows no temperature: uniform heat. The segments
  // are finer than the reach. What is left is that h falls towards the cool ends: about 1 %.
  constexpr std::size_t count = 80;
  using Fin = DistributedPlant<papers::Cosine<double>, count>;
  const Wire<double>& wire = paper_wire();
  Fin::Params p{};
  p.kinetics.fill({{600, 610, 1e7}, {590, 580, 1e7}});
  p.material = wire.material;
  p.material.martensite.resistivity_ohm_m_K = 0;
  p.heat = wire.heat;
  p.geometry = {0.012, wire.geometry.diameter_m};
  p.length_m.fill(0.012 / count);
  Fin::State s = Fin::rest(p, {ambient_K, 100e6});
  const double current = 0.08;
  for (int i = 0; i < 10000; ++i) {
    Fin::advance(p, s, current, {100e6, ambient_K}, 1.0, 1e-3);
  }
  // Analytical: theta = q/(h P) (1 - cosh((x - L/2)/lambda)/cosh(L/2 lambda)), with h of the middle
  const double middle_K = Fin::temperature_K(s, count / 2);
  const double h = natural_convection_W_m2K(p.geometry.diameter_m, middle_K, ambient_K);
  const double lambda_m =
      std::sqrt(p.heat.clamp_conductivity_W_mK * p.geometry.diameter_m / (4 * h));
  const double free_K =
      current * current * Fin::resistance_ohm(p, s) / (h * p.geometry.surface_m2());
  double worst = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const double x = (static_cast<double>(i) + 0.5) * 0.012 / count - 0.006;
    const double fin = 1 - std::cosh(x / lambda_m) / std::cosh(0.006 / lambda_m);
    worst = std::max(worst, std::abs((Fin::temperature_K(s, i) - ambient_K) / free_K - fin));
    EXPECT_NEAR(Fin::temperature_K(s, i), Fin::temperature_K(s, count - 1 - i), 1e-9);
  }
  std::printf("middle %.1f K above the air, worst deviation from the fin %.2f %%\n",
              middle_K - ambient_K, 100 * worst);
  EXPECT_LT(worst, 0.015);
  EXPECT_GT(middle_K - ambient_K, 20);
  EXPECT_LT(Fin::temperature_K(s, 0) - ambient_K, 0.1 * (middle_K - ambient_K));
}

}  // namespace
}  // namespace smaservo::test::distributed_test
