#include "host-sim/tune/proposal.hpp"

#include <gtest/gtest.h>
#include <limits>

#include "firmware/parameters/parameter_check.hpp"
#include "host-sim/tune/linear/uncertainty.hpp"
#include "host-sim/tune/output/rounding.hpp"
#include "model/files/error.hpp"
#include "model/files/wire/wire_file.hpp"
#include "model/units.hpp"

namespace smaservo::tune {
namespace {

constexpr double unlimited = std::numeric_limits<double>::infinity();

TuneTask proposal_task(const char* wire, double stress_MPa, double ambient_degC = 25) {
  const double stress_Pa = 1e6 * stress_MPa;
  return {{files::load_wire(wire).wire, {stress_Pa, stress_Pa, 0}, ambient_degC + zero_degC_K, 1},
          unlimited,
          8,
          1};
}
TuneTask spring(const char* wire, double low_MPa, double high_MPa) {
  TuneTask t = proposal_task(wire, low_MPa);
  t.plant.load = {1e6 * low_MPa, 1e6 * high_MPa, 0.04};
  return t;
}

const DesignedLoop& loop(const Proposal& p, LoopName name) {
  return p.loops[static_cast<std::size_t>(name)];
}

TEST(Proposal, KeepsTheMarginsOfEveryWireInEveryState) {
  std::vector<TuneTask> tasks;
  for (const char* wire : {"smartflex-25um", "smartflex-76um", "smartflex-500um"}) {
    tasks.push_back(proposal_task(wire, 60));
    tasks.push_back(proposal_task(wire, 200));
  }
  tasks.push_back(proposal_task("flexinol-lt-0.050mm", 100));
  tasks.push_back(proposal_task("flexinol-ht-0.38mm", 150));
  tasks.push_back(proposal_task("smartflex-76um", 400));
  tasks.push_back(spring("smartflex-76um", 100, 250));
  for (const TuneTask& t : tasks) {
    const Proposal p = propose(t);
    for (const DesignedLoop& l : p.loops) {
      EXPECT_EQ(l.possible, l.name != LoopName::force || t.plant.load.is_spring());
      // Asked again, loop by loop, of the settings as they are proposed.
      for (const LinearLoop& linear : l.loops) {
        const Margins m = margins(linear);
        EXPECT_TRUE(m.stable && m.gain >= 2 && m.sensitivity <= 2 &&
                    m.phase_rad >= 0.25 * std::numbers::pi)
            << loop_text(l.name);
        EXPECT_GE(m.phase_rad, l.worst.phase_rad);
      }
    }
  }
}

TEST(Rounding, LeavesThreeDigits) {
  EXPECT_EQ(rounded_up(2.5e-3), 2.5e-3);
  EXPECT_EQ(rounded_down(2.5e-3), 2.5e-3);
  EXPECT_EQ(rounded_up(0.12341), 0.124);
  EXPECT_EQ(rounded_down(0.12389), 0.123);
  EXPECT_EQ(rounded_up(187.5e6), 188e6);
  EXPECT_EQ(rounded_down(9.999), 9.99);
  EXPECT_EQ(rounded_up(0), 0);
}

TEST(Proposal, IsTheSameEachTime) {
  const Proposal a = propose(proposal_task("smartflex-76um", 150));
  const Proposal b = propose(proposal_task("smartflex-76um", 150));
  EXPECT_EQ(a.settings.temperature.proportional, b.settings.temperature.proportional);
  EXPECT_EQ(a.settings.strain.dead_band, b.settings.strain.dead_band);
  EXPECT_EQ(loop(a, LoopName::strain).worst.phase_rad, loop(b, LoopName::strain).worst.phase_rad);
}

/// Mass by length goes with the square of the diameter, and power by kelvin with the mass; current
/// and cooling time rise.
TEST(Proposal, OfAThickerWireTakesMorePower) {
  double watts = 0, amperes = 0, seconds = 0, diameter_m = 0;
  for (const char* wire :
       {"smartflex-25um", "smartflex-76um", "smartflex-150um", "smartflex-400um"}) {
    const TuneTask t = proposal_task(wire, 150);
    const Proposal p = propose(t);
    const double d = t.plant.wire.geometry.diameter_m;
    if (diameter_m > 0) {
      const double mass = (d / diameter_m) * (d / diameter_m);
      EXPECT_NEAR(p.settings.temperature.proportional / watts, mass, 0.02 * mass);
      EXPECT_GT(p.settings.limits.current_A, amperes);
      EXPECT_GT(p.branches.cooling_s, seconds);
    }
    watts = p.settings.temperature.proportional;
    amperes = p.settings.limits.current_A;
    seconds = p.branches.cooling_s;
    diameter_m = d;
  }
}

TEST(Proposal, FollowsTheSurroundings) {
  const Proposal cool = propose(proposal_task("smartflex-76um", 150, 10));
  const Proposal warm = propose(proposal_task("smartflex-76um", 150, 40));
  EXPECT_GT(cool.settings.trajectory.cooling_rate_1_s, warm.settings.trajectory.cooling_rate_1_s);
  EXPECT_LT(cool.branches.cooling_s, warm.branches.cooling_s);
  EXPECT_GT(cool.holding_A, warm.holding_A);
  const Proposal light = propose(proposal_task("smartflex-76um", 60));
  const Proposal heavy = propose(proposal_task("smartflex-76um", 350));
  EXPECT_LT(light.settings.limits.temperature_K, heavy.settings.limits.temperature_K);
  EXPECT_LT(light.settings.limits.stress_Pa, heavy.settings.limits.stress_Pa);
}

TEST(Proposal, OfAWireThatIsKnownBetterHasASmallerDeadBand) {
  TuneTask known = proposal_task("smartflex-76um", 150);
  known.plant.wire.accuracy.strain = 5e-4;
  EXPECT_LT(propose(known).settings.strain.dead_band,
            propose(proposal_task("smartflex-76um", 150)).settings.strain.dead_band);
}

/// What parameters must fulfil, singly and as a set, in the floats of a device.
TEST(Proposal, DoesNotContradictItself) {
  for (const TuneTask& t :
       {proposal_task("smartflex-76um", 0), proposal_task("smartflex-25um", 100),
        proposal_task("flexinol-ht-0.51mm", 150), proposal_task("smartflex-76um", 590),
        spring("smartflex-150um", 50, 250)}) {
    const Settings<double> s = stored_settings<double>(propose(t).settings);
    const Finding found = check(s);
    EXPECT_TRUE(found.ok()) << parameters<double>[found.parameter].path.text();
    EXPECT_LT(s.trips.slack_Pa, t.plant.load.low_Pa);
  }
}

TEST(Proposal, StaysBelowAGivenCurrent) {
  TuneTask t = proposal_task("smartflex-76um", 150);
  t.max_current_A = 0.2;
  const Proposal p = propose(t);
  EXPECT_EQ(p.settings.limits.current_A, 0.2);
  t.max_current_A = 0.9 * p.holding_A;
  EXPECT_THROW(propose(t), files::UserError);
}

TEST(Proposal, RefusesAirInWhichTheWireDoesNotStretch) {
  EXPECT_THROW(propose(proposal_task("smartflex-76um", 10, 70)), files::UserError);
}

TEST(Uncertainty, IsDrawnAroundTheFile) {
  const TunedPlant file = proposal_task("smartflex-76um", 150).plant;
  const auto all = uncertain_plants(file, 200, 7);
  ASSERT_EQ(all.size(), 200U);
  EXPECT_EQ(all[0].draught, 1);
  EXPECT_EQ(all[1].draught, 0.8);
  EXPECT_EQ(all[2].draught, 1.5);
  double latent = 0, square = 0;
  for (std::size_t i = 3; i < all.size(); ++i) {
    EXPECT_GE(all[i].draught, 0.8);
    EXPECT_LE(all[i].draught, 1.5);
    EXPECT_NEAR(all[i].ambient_K, file.ambient_K, 3);
    const double off = all[i].wire.heat.latent_m2a_J_kg / file.wire.heat.latent_m2a_J_kg - 1;
    latent += off / 197;
    square += off * off / 197;
  }
  EXPECT_NEAR(latent, 0, 0.015);
  EXPECT_NEAR(std::sqrt(square), 0.06, 0.01);
  EXPECT_EQ(uncertain_plants(file, 5, 7)[4].wire.heat.specific_heat_J_kgK,
            all[4].wire.heat.specific_heat_J_kgK);
}

}  // namespace
}  // namespace smaservo::tune
