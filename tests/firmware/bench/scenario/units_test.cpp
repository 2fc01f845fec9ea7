#include "firmware/bench/scenario/units.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <vector>

#include "model/wire/plant.hpp"

namespace smaservo::test {
namespace {

const Wire<double>& preset() {
  static const Wire<double> wire = files::load_wire(std::string(files::default_wire)).wire;
  return wire;
}

double deviation(const std::vector<double>& values, double from) {
  double sum = 0;
  for (const double value : values) {
    sum += (value - from) * (value - from);
  }
  return std::sqrt(sum / static_cast<double>(values.size()));
}

TEST(RandomUnit, SeedAndFamilyDecide) {
  EXPECT_EQ(files::to_toml(bench::random_unit(hal::Family::ihyp, 7).wire),
            files::to_toml(bench::random_unit(hal::Family::ihyp, 7).wire));
  EXPECT_NE(bench::random_unit(hal::Family::ihyp, 7).wire.wire.geometry.length_m,
            bench::random_unit(hal::Family::ihyp, 8).wire.wire.geometry.length_m);
  EXPECT_EQ(bench::random_unit(hal::Family::sublayers, 7).structure.sublayers.seed,
            bench::random_unit(hal::Family::sublayers, 7).structure.sublayers.seed);
  EXPECT_NE(bench::random_unit(hal::Family::sublayers, 7).structure.sublayers.seed,
            bench::random_unit(hal::Family::sublayers, 8).structure.sublayers.seed);
  const auto smooth = [](std::uint64_t seed) {
    return bench::random_unit(hal::Family::smooth_hardening, seed).structure.smooth_hardening;
  };
  EXPECT_EQ(smooth(7).clamp_resistance_m, smooth(7).clamp_resistance_m);
  EXPECT_NE(smooth(7).clamp_resistance_m, smooth(8).clamp_resistance_m);
}

TEST(RandomUnit, SpreadsAsOneWireFromAnother) {
  std::vector<double> start_K, slope, curvature, strain, length, diameter, austenite;
  const Wire<double>& p = preset();
  for (std::uint64_t seed = 0; seed < 400; ++seed) {
    const Wire<double> w =
        bench::random_unit(seed % 2 == 0 ? hal::Family::ihyp : hal::Family::sublayers, seed)
            .wire.wire;
    start_K.push_back(w.kinetics.m2a.start_K[0] - p.kinetics.m2a.start_K[0]);
    slope.push_back(w.kinetics.m2a.start_K[1] / p.kinetics.m2a.start_K[1]);
    curvature.push_back(w.kinetics.m2a.curvature[0] / p.kinetics.m2a.curvature[0]);
    strain.push_back(w.material.martensite.strain / p.material.martensite.strain);
    length.push_back(w.geometry.length_m / p.geometry.length_m);
    diameter.push_back(w.geometry.diameter_m / p.geometry.diameter_m);
    austenite.push_back(w.material.austenite.resistivity_ohm_m /
                        p.material.austenite.resistivity_ohm_m);
  }
  // Four standard errors of 400 draws are 14 %.
  EXPECT_NEAR(deviation(start_K, 0), 1.5, 0.14 * 1.5);
  EXPECT_NEAR(deviation(slope, 1), 0.04, 0.14 * 0.04);
  EXPECT_NEAR(deviation(curvature, 1), 0.10, 0.14 * 0.10);
  EXPECT_NEAR(deviation(strain, 1), 0.03, 0.14 * 0.03);
  EXPECT_NEAR(deviation(length, 1), 0.005, 0.14 * 0.005);
  EXPECT_NEAR(deviation(diameter, 1), 0.01, 0.14 * 0.01);
  EXPECT_NEAR(deviation(austenite, 1), 0.01, 0.14 * 0.01);
}

TEST(RandomUnit, EveryWireIsOneThatAFileMayDescribe) {
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    for (const hal::Family family : hal::families) {
      const files::WireDescription wire = bench::random_unit(family, seed).wire;
      EXPECT_NO_THROW(files::parse_wire(files::to_toml(wire), wire.name)) << wire.name;
    }
  }
}

TEST(RandomUnit, SmoothHardeningHasRPhaseOnCoolingAndLittleOnHeating) {
  double most_heated = 0;
  double sum = 0;
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    const bench::WireUnit unit = bench::random_unit(hal::Family::smooth_hardening, seed);
    std::mt19937_64 random;
    const auto wire =
        hal::make_simulated_wire(unit.family, unit.wire.wire, unit.structure, 0, random);
    double most_cooled = 0;
    wire->rest(450, 10e6);
    for (double T = 450; T > 250; T -= 0.5) {
      wire->soak(T, 10e6);
      most_cooled = std::max(most_cooled, wire->phases().r_phase);
    }
    sum += most_cooled;
    wire->rest(200, 0);
    for (double T = 250; T < 450; T += 0.5) {
      wire->soak(T, 0);
      most_heated = std::max(most_heated, wire->phases().r_phase);
    }
  }
  EXPECT_NEAR(sum / 50, 0.7, 0.1);
  EXPECT_LT(most_heated, 0.03);
}

TEST(RandomUnit, TypeFileIsThePresetWithTheUnitsColdResistance) {
  for (const hal::Family family : hal::families) {
    for (std::uint64_t seed = 0; seed < 10; ++seed) {
      const bench::WireUnit unit = bench::random_unit(family, seed);
      const Wire<double> type = unit.type_file();
      std::mt19937_64 random;
      const auto cold = hal::make_simulated_wire(family, unit.wire.wire, unit.structure, 0, random);
      cold->rest(room_K, 0);
      EXPECT_NEAR(cold_resistance_ohm(type) / cold->resistance_ohm(), 1, 1e-6);
      EXPECT_EQ(type.geometry.diameter_m, preset().geometry.diameter_m);
      EXPECT_EQ(type.kinetics.m2a.start_K[0], preset().kinetics.m2a.start_K[0]);
    }
  }
}

}  // namespace
}  // namespace smaservo::test
