// All families are the wire that they are made from.

#include "hal/sim/simulated_wire.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <vector>

#include "model/files/wire/wire_file.hpp"
#include "model/units.hpp"

namespace smaservo::test::simulated_wire_test {
namespace {

class SimulatedFamily : public ::testing::TestWithParam<hal::Family> {
 protected:
  static std::unique_ptr<hal::SimulatedWire> make(std::uint64_t seed = 1) {
    std::mt19937_64 random(seed);
    return hal::make_simulated_wire(
        GetParam(), files::load_wire(std::string(files::default_wire)).wire, {}, 0.5, random);
  }
};

INSTANTIATE_TEST_SUITE_P(Families, SimulatedFamily, ::testing::ValuesIn(hal::families),
                         [](const auto& tested) {
                           std::string name(hal::family_name(tested.param));
                           std::erase(name, '-');
                           return name;
                         });

/// A full cycle of the temperature at constant stress.
struct Cycle {
  /// Temperatures of half martensite on cooling, and of half austenite on heating.
  double cooling_K, heating_K;
  double peak_r_phase;  ///< greatest fraction of R-phase on cooling
};
Cycle cycle(hal::SimulatedWire& wire, double stress_MPa) {
  Cycle c{};
  const double hot_K = 450;
  const double cold_K = 270;
  wire.rest(hot_K, 1e6 * stress_MPa);
  for (double T = hot_K; T > cold_K; T -= 0.1) {
    wire.soak(T, 1e6 * stress_MPa);
    c.peak_r_phase = std::max(c.peak_r_phase, wire.phases().r_phase);
    c.cooling_K = wire.phases().martensite < 0.5 ? T : c.cooling_K;
  }
  for (double T = cold_K; T < hot_K; T += 0.1) {
    wire.soak(T, 1e6 * stress_MPa);
    c.heating_K = wire.phases().austenite() < 0.5 ? T : c.heating_K;
  }
  return c;
}

TEST_P(SimulatedFamily, TransformsWhereTheRealWireDoes) {
  const auto wire = make();
  const Cycle none = cycle(*wire, 0);
  EXPECT_TRUE(none.heating_K > 70 + zero_degC_K && none.heating_K < 80 + zero_degC_K);
  EXPECT_TRUE(none.cooling_K > 36 + zero_degC_K && none.cooling_K < 44 + zero_degC_K);
  const Cycle high = cycle(*wire, 300);
  for (const double K_MPa :
       {(high.heating_K - none.heating_K) / 300, (high.cooling_K - none.cooling_K) / 300}) {
    EXPECT_TRUE(K_MPa > 0.12 && K_MPa < 0.16) << K_MPa;
  }
  // Paper 000: about 70 % of R-phase at 10 MPa, felt up to almost 250 MPa.
  const double peak = cycle(*wire, 10).peak_r_phase;
  EXPECT_TRUE(peak > 0.65 && peak < 0.8) << peak;
  const double last = cycle(*wire, 250).peak_r_phase;
  EXPECT_TRUE(last > 0.08 && last < 0.2) << last;
}

/// Strain, resistance and temperatures over a heating and a cooling.
std::vector<double> journey(hal::SimulatedWire& wire) {
  std::vector<double> all;
  wire.rest(room_K, 150e6);
  for (int i = 0; i < 4000; ++i) {
    wire.advance(i < 2000 ? 0.135 : 0.012, {150e6, room_K, 1}, 1e-3);
    if (i % 100 == 99) {
      all.insert(all.end(),
                 {wire.strain(), wire.resistance_ohm(), wire.hottest_K(), wire.average_K()});
    }
  }
  return all;
}

TEST_P(SimulatedFamily, SameSeedGivesTheSameWire) {
  const std::vector<double> one = journey(*make());
  const auto again = make();
  EXPECT_EQ(one, journey(*again));
  EXPECT_EQ(one, journey(*again)) << "rest() forgets all";
  EXPECT_NE(one, journey(*make(2)));
}

TEST_P(SimulatedFamily, EndsStayColdAndAirCools) {
  const auto wire = make();
  wire->rest(room_K, 150e6);
  const double cold_ohm = wire->resistance_ohm();
  for (int i = 0; i < 3000; ++i) {
    wire->advance(0.135, {150e6, room_K, 1}, 1e-3);
  }
  EXPECT_GT(wire->hottest_K(), 365);
  EXPECT_LT(wire->average_K(), wire->hottest_K() - 1);
  EXPECT_LT(wire->resistance_ohm(), 0.9 * cold_ohm);
  const double still_K = wire->hottest_K();
  for (int i = 0; i < 3000; ++i) {
    wire->advance(0.135, {150e6, room_K, 1.2}, 1e-3);
  }
  EXPECT_LT(wire->hottest_K(), still_K - 5);
}

/// The temperature at which this share has become martensite, or austenite again.
double soaked_K(hal::SimulatedWire& wire, double stress_MPa, double share, bool heating) {
  const double sign = heating ? 1 : -1;
  double T = heating ? 250 : 500;
  // From so far away that the tails of the ihyp curve are over.
  wire.rest(-sign * 1e6, 1e6 * stress_MPa);
  wire.soak(T, 1e6 * stress_MPa);
  const auto converted = [&] {
    const double martensite = wire.phases().martensite;
    return heating ? 1 - martensite : martensite;
  };
  while (converted() < share) {
    T += sign * 0.01;
    wire.soak(T, 1e6 * stress_MPa);
  }
  return T;
}

TEST(SimulatedWires, SmoothHardeningTakesItsTemperaturesFromTheWire) {
  const Wire<double> wire = files::load_wire(std::string(files::default_wire)).wire;
  std::mt19937_64 random(1);
  // Every segment of `ihyp` has the wire's surfaces.
  const auto is = hal::make_simulated_wire(hal::Family::smooth_hardening, wire, {}, 0, random);
  const auto as = hal::make_simulated_wire(hal::Family::ihyp, wire, {}, 0, random);
  for (const bool heating : {false, true}) {
    const auto off_K = [&](double stress_MPa, double share) {
      return soaked_K(*is, stress_MPa, share, heating) - soaked_K(*as, stress_MPa, share, heating);
    };
    EXPECT_NEAR(off_K(0, 0.5), 0, 0.03);
    EXPECT_NEAR(off_K(400, 0.5), 0, 0.03);
    EXPECT_NEAR(off_K(0, 0.8) - off_K(0, 0.2), 0, 0.04);
    // Over stress it goes its own way: the strain that the stress works on is less at first.
    EXPECT_LT(off_K(150, 0.5), -0.5);
    EXPECT_GT(off_K(150, 0.5), -4);
  }
}

/// The ends of a hot wire are martensite, over less than its file's conductivity would keep cold.
TEST(SimulatedWires, SmoothHardeningHasColdEndsOfItsOwn) {
  const Wire<double> wire = files::load_wire(std::string(files::default_wire)).wire;
  std::mt19937_64 random(1);
  const auto left = [&](const hal::SmoothHardeningStructure& structure) {
    const auto hot = hal::make_simulated_wire(hal::Family::smooth_hardening, wire,
                                              {{}, {}, structure}, 0, random);
    hot->rest(room_K, 150e6);
    for (int i = 0; i < 10000; ++i) {
      hot->advance(0.15, {150e6, room_K, 1}, 1e-3);
    }
    EXPECT_GT(hot->hottest_K(), 385);
    return hot->phases().martensite;
  };
  hal::SmoothHardeningStructure structure;
  const double own = left(structure);
  structure.conduction = 1;
  structure.clamp_resistance_m = 0;
  const double as_in_the_file = left(structure);
  EXPECT_LT(own, 0.85 * as_in_the_file);
  EXPECT_GT(own, 0.5 * as_in_the_file);
  EXPECT_GT(own, 0.015);
}

TEST(SimulatedWires, FamiliesDifferInMoreThanNoise) {
  // The same wire and the same currents; a calibrated observer has errors of 0.2 % of stroke.
  const Wire<double> wire = files::load_wire(std::string(files::default_wire)).wire;
  std::mt19937_64 random(1);
  const auto a = journey(*hal::make_simulated_wire(hal::Family::ihyp, wire, {}, 0, random));
  const auto b = journey(*hal::make_simulated_wire(hal::Family::sublayers, wire, {}, 0, random));
  double worst = 0;
  for (std::size_t i = 0; i < a.size(); i += 4) {
    worst = std::max(worst, std::abs(a[i] - b[i]) / 0.04);
  }
  EXPECT_TRUE(worst > 0.05 && worst < 0.5) << worst;
}

}  // namespace
}  // namespace smaservo::test::simulated_wire_test
