// The linearisation against the plant in time: a little more power than it loses.

#include "host-sim/tune/linear/operating_points.hpp"

#include <gtest/gtest.h>

#include "model/files/wire/wire_file.hpp"

namespace smaservo::tune {
namespace {

TunedPlant plant(const char* wire, const TunedLoad& load, double draught = 1) {
  return {files::load_wire(wire).wire, load, room_K, draught};
}

constexpr double max_K = 400;

void moves_as_its_linearisation_says(const TunedPlant& tuned) {
  const LumpedModel::Params params = lumped_params(tuned);
  const Branches b = trace_branches(tuned, max_K);
  ASSERT_EQ(b.points.size(), 21U);
  for (const OperatingPoint& p : b.points) {
    LumpedModel::State state = p.state;
    // In 2 ms by 0.02 K, onwards.
    constexpr double dt_s = 1e-4;
    const double sign = p.motion == Motion::heating ? 1 : -1;
    const double heat_W = sign * p.capacity_J_K * 10;
    double stress_Pa = p.stress_Pa;
    for (int i = 0; i < 20; ++i) {
      stress_Pa = advance_loaded(tuned, params, state, p.loss_W + heat_W, b.rest_strain, dt_s);
    }
    const double K = LumpedModel::temperature_K(state) - p.temperature_K;
    EXPECT_NEAR(K, sign * 0.02, 0.002) << motion_name(p.motion) << p.share;
    const double strain = LumpedModel::strain(params, state) - p.strain;
    EXPECT_NEAR(strain, p.strain_1_K * K, 0.03 * std::abs(p.strain_1_K * K) + 1e-9);
    const double ohm = LumpedModel::resistance_ohm(params, state, tuned.ambient_K) - p.ohm;
    EXPECT_NEAR(ohm, p.ohm_1_K * K, 0.05 * std::abs(p.ohm_1_K * K) + 1e-6);
    const double N = (stress_Pa - p.stress_Pa) * tuned.wire.geometry.area_m2();
    EXPECT_NEAR(N, p.load_N_K * K, 0.05 * std::abs(p.load_N_K * K) + 1e-6);
  }
}

TEST(OperatingPoints, MoveAsTheirLinearisationSays) {
  for (const double stress_Pa : {50e6, 150e6, 300e6}) {
    moves_as_its_linearisation_says(plant("smartflex-76um", {stress_Pa, stress_Pa, 0}));
  }
  moves_as_its_linearisation_says(plant("flexinol-ht-0.25mm", {150e6, 150e6, 0}, 1.5));
}

TEST(OperatingPoints, MoveAsTheirLinearisationSaysAgainstASpring) {
  moves_as_its_linearisation_says(plant("smartflex-76um", {100e6, 200e6, 0.04}));
  moves_as_its_linearisation_says(plant("smartflex-150um", {50e6, 250e6, 0.02}));
}

/// What a spring's wire bears is what the spring pulls.
TEST(OperatingPoints, BalanceTheSpring) {
  const TunedPlant tuned = plant("smartflex-76um", {50e6, 300e6, 0.02});
  const Branches b = trace_branches(tuned, max_K);
  for (const OperatingPoint& p : b.points) {
    EXPECT_NEAR(p.stress_Pa, tuned.load.stress_Pa(b.rest_strain - p.strain), 1e3);
  }
}

/// But for the branches' tails.
TEST(OperatingPoints, TurnedWiresKeepTheirStrain) {
  for (const double stress_Pa : {100e6, 300e6}) {
    const Branches b = trace_branches(plant("smartflex-76um", {stress_Pa, stress_Pa, 0}), max_K);
    double max = 0;
    for (const OperatingPoint& p : b.points) {
      max = std::max(max, std::abs(p.strain_1_K));
    }
    int turned = 0;
    for (const OperatingPoint& p : b.points) {
      if (p.motion == Motion::turned) {
        ++turned;
        EXPECT_LT(std::abs(p.strain_1_K), 0.03 * max);
      }
    }
    EXPECT_EQ(turned, 3);
  }
}

/// All heat of a stroke comes in or goes out: integrated by the capacities of many stops.
TEST(OperatingPoints, CapacitiesAddUpToTheHeatOfTheStroke) {
  const TunedPlant tuned = plant("smartflex-76um", {150e6, 150e6, 0});
  std::vector<OperatingPoint> heating;
  for (const OperatingPoint& p : trace_branches(tuned, max_K, 199).points) {
    if (p.motion == Motion::heating) {
      heating.push_back(p);
    }
  }
  ASSERT_EQ(heating.size(), 199U);
  double heat_J = 0;
  for (std::size_t i = 1; i < heating.size(); ++i) {
    heat_J += 0.5 * (heating[i - 1].capacity_J_K + heating[i].capacity_J_K) *
              (heating[i].temperature_K - heating[i - 1].temperature_K);
  }
  const ThermalBody<double> body = lumped_params(tuned).body;
  const Phases<double> from = LumpedModel::phases(heating.front().state);
  const Phases<double> to = LumpedModel::phases(heating.back().state);
  const double warmer_K = heating.back().temperature_K - heating.front().temperature_K;
  const double expected_J = body.capacity_J_K * warmer_K +
                            body.latent_m2a_J * (from.martensite - to.martensite) +
                            body.latent_r2a_J * (from.r_phase - to.r_phase);
  EXPECT_NEAR(heat_J, expected_J, 0.01 * expected_J);
}

}  // namespace
}  // namespace smaservo::tune
