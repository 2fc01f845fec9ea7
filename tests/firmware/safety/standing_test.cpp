#include "firmware/safety/standing.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <random>
#include <vector>

#include "tests/firmware/device/rig.hpp"

namespace smaservo::standing_test {
namespace {

constexpr double dt_s = 1e-3;

std::vector<Fault> warnings() {
  std::vector<Fault> all;
  for_each_fault(warning_faults, [&](Fault fault) { all.push_back(fault); });
  return all;
}

/// Each warning as its definition says: from the step of a cause to a second after the last one.
class Definition {
 public:
  void step(FaultSet now, bool clear) {
    for (const Fault fault : warnings()) {
      One& one = all_.at(warning_index(fault));
      const bool present = now.has(fault);
      one.came += present && !one.present ? 1U : 0U;
      one.present = present;
      one.gone_steps = present ? 0 : one.gone_steps + 1;
      one.cleared = !present && (one.cleared || clear);
    }
  }
  bool stands(Fault fault) const {
    const One& one = all_.at(warning_index(fault));
    return one.present || (one.came > 0 && !one.cleared && one.gone_steps * dt_s < 1 - 1e-9);
  }
  std::uint32_t came(Fault fault) const { return all_.at(warning_index(fault)).came; }

 private:
  struct One {
    bool present = false, cleared = false;
    int gone_steps = 0;
    std::uint32_t came = 0;
  };
  std::array<One, warning_count> all_{};
};

TEST(StandingWarnings, StandAndCountAsTheirDefinitionSays) {
  for (unsigned seed = 0; seed < 40; ++seed) {
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> uniform;
    StandingWarnings<double> s{};
    Definition definition;
    FaultSet now;
    // From causes that change at each step to those that stay away for longer than a second.
    const double change = std::pow(10, -1 - 3 * uniform(random));
    for (int i = 0; i < 8000; ++i) {
      for (const Fault fault : warnings()) {
        if (uniform(random) < change) {
          now.set(fault, !now.has(fault));
        }
      }
      const bool clear = uniform(random) < change / 100;
      const FaultSet shown = s.step(now, clear, dt_s);
      definition.step(now, clear);
      for (const Fault fault : warnings()) {
        ASSERT_EQ(shown.has(fault), definition.stands(fault))
            << fault_name(fault) << " at step " << i << ", seed " << seed;
        ASSERT_EQ(s.came.at(warning_index(fault)), definition.came(fault)) << fault_name(fault);
      }
      ASSERT_TRUE((shown - warning_faults).empty());
    }
  }
}

/// A reader that has missed whatever outputs has all counts after as many steps as there are
/// warnings.
TEST(StandingWarnings, TellEachCountInTurn) {
  std::mt19937_64 random(1);
  StandingWarnings<float> s{};
  WarningCounts read{};
  for (int round = 0; round < 200; ++round) {
    const auto missed = random() % 100;
    for (std::uint64_t i = 0; i < missed; ++i) {
      s.step(FaultSet::from_bits(random()) & warning_faults, false, 1e-3F);
    }
    for (std::size_t i = 0; i < warning_count; ++i) {
      s.step(s.present, false, 1e-3F);  // nothing new comes
      read.at(s.told().place) = s.told().causes;
    }
    ASSERT_EQ(read, s.came) << "round " << round;
  }
}

TEST(StandingWarnings, EachFaultHasItsOwnPlace) {
  std::vector<int> used(warning_count, 0);
  for (const Fault fault : warnings()) {
    ++used.at(warning_index(fault));
  }
  EXPECT_EQ(used, std::vector<int>(warning_count, 1));
}

/// An estimate that is 25 K too low, so that the soft limit of the temperature does not act: what
/// limits the heat is the heat balance, whose limiter the reduced current ends at once.
TEST(StandingWarnings, DoNotFlickerWhereAWireIsPressedAgainstItsLimit) {
  Rig rig = plain_rig();
  rig.run(0.2);
  rig.tamper_estimate = [](Estimate<double>& e) { e.temperature_K -= 25; };
  rig.arm(Mode::power, 10);
  const std::size_t limit = warning_index(Fault::heat_limit);
  ASSERT_TRUE(rig.out.warnings.has(Fault::heat_limit));
  std::uint32_t causes = rig.state.supervisor.warnings.came.at(limit);
  bool before = rig.out.active.has(Fault::heat_limit);
  for (int i = 0; i < 60'000; ++i) {
    rig.step();
    const bool present = rig.out.active.has(Fault::heat_limit);
    causes += present && !before ? 1U : 0U;
    before = present;
    ASSERT_TRUE(rig.out.warnings.has(Fault::heat_limit)) << "at step " << i;
    ASSERT_TRUE(rig.out.limited_by(LimitReason::protection));
  }
  EXPECT_EQ(rig.state.supervisor.warnings.came.at(limit), causes);
  EXPECT_GT(causes, 1000U) << "otherwise there is nothing here that could flicker";
  rig.command.arm = false;
  rig.run(1.1);
  EXPECT_TRUE(rig.out.warnings.empty());
}

}  // namespace
}  // namespace smaservo::standing_test
