#include "firmware/safety/failsafe.hpp"

#include <array>
#include <gtest/gtest.h>

namespace smaservo::failsafe_test {
namespace {

constexpr std::array states{DeviceState::starting, DeviceState::ready,    DeviceState::arming,
                            DeviceState::running,  DeviceState::stopping, DeviceState::fault};
static_assert(states.size() == device_state_count);
constexpr std::array safe_states{SafeState::off, SafeState::hold, SafeState::release};

/// One fault of each class stands for its class.
constexpr std::array representatives{Fault::over_current, Fault::wire_open, Fault::over_stress,
                                     Fault::duty,         Fault::drift,     Fault::cycles};
static_assert(representatives.size() == fault_class_count);

FaultSet some_faults(unsigned classes) {
  FaultSet set;
  for (std::size_t i = 0; i < representatives.size(); ++i) {
    set.add(representatives[i], (classes >> i & 1U) != 0);
  }
  return set;
}

bool any(FaultSet set, FaultClass severity) {
  return !(set & faults_of(severity)).empty();
}

/// Calls f with every combination: what is active by class, what is latched of F0 to F2, flags.
template <class F>
void for_every_input(F f) {
  for (const DeviceState state : states) {
    for (const SafeState safe : safe_states) {
      for (unsigned classes = 0; classes < 64; ++classes) {
        for (unsigned latched = 0; latched < 8; ++latched) {
          for (unsigned flags = 0; flags < 256; ++flags) {
            const auto flag = [&](unsigned i) { return (flags >> i & 1U) != 0; };
            f(FailsafeInput{state, some_faults(classes), some_faults(latched), flag(0), flag(1),
                            flag(2), flag(3), flag(4), flag(5), safe, flag(6), flag(7)});
          }
        }
      }
    }
  }
}

TEST(Failsafe, RepresentsEveryClass) {
  for (std::size_t i = 0; i < representatives.size(); ++i) {
    EXPECT_EQ(fault_row(representatives[i]).severity, static_cast<FaultClass>(i));
  }
}

using Broken = bool (*)(const FailsafeInput&, const FailsafeOutput&);

bool heats(const FailsafeOutput& out) {
  return out.heat != Heat::none;
}
Heat configured(SafeState safe) {
  return safe == SafeState::hold      ? Heat::hold
         : safe == SafeState::release ? Heat::release
                                      : Heat::none;
}
bool heats_with_f0_or_f1(const FailsafeInput& in, const FailsafeOutput& out) {
  const FaultSet all = in.active | in.latched;
  return heats(out) && (any(all, FaultClass::F0) || any(all, FaultClass::F1));
}
bool heats_outside_a_heated_state(const FailsafeInput& /*in*/, const FailsafeOutput& out) {
  return heats(out) != is_heated(out.state);
}
bool leaves_the_safe_state(const FailsafeInput& in, const FailsafeOutput& out) {
  const bool allowed = out.heat == configured(in.safe) && in.may_hold;
  return any(in.active | in.latched, FaultClass::F2) && heats(out) && !allowed;
}
bool holds_without_end(const FailsafeInput& in, const FailsafeOutput& out) {
  return (out.heat == Heat::hold || out.heat == Heat::release) && in.safe_over;
}
bool heats_though_disarmed(const FailsafeInput& in, const FailsafeOutput& out) {
  return heats(out) && !in.arm;
}
bool arms_against_a_block(const FailsafeInput& in, const FailsafeOutput& out) {
  return in.state == DeviceState::ready && heats(out) && (in.blocked || !in.arm_edge);
}
bool runs_unchecked(const FailsafeInput& in, const FailsafeOutput& out) {
  const bool passed = in.checked && in.passed && !in.blocked;
  return in.state == DeviceState::arming && out.state == DeviceState::running && !passed;
}
bool leaves_the_fault_too_early(const FailsafeInput& in, const FailsafeOutput& out) {
  const bool stays = out.state == DeviceState::fault;
  return in.state == DeviceState::fault && (heats(out) || (!in.latched.empty() && !stays));
}
bool jumps_into_running(const FailsafeInput& in, const FailsafeOutput& out) {
  return out.state == DeviceState::running && in.state != DeviceState::running &&
         in.state != DeviceState::arming;
}
bool jumps_into_stopping(const FailsafeInput& in, const FailsafeOutput& out) {
  return out.state == DeviceState::stopping && in.state != DeviceState::running &&
         in.state != DeviceState::stopping;
}

constexpr std::array<Broken, 10> promises{heats_with_f0_or_f1,   heats_outside_a_heated_state,
                                          leaves_the_safe_state, holds_without_end,
                                          heats_though_disarmed, arms_against_a_block,
                                          runs_unchecked,        leaves_the_fault_too_early,
                                          jumps_into_running,    jumps_into_stopping};

/// The test counts broken promises, because assertions for each of two million cases would take
/// most of its time.
TEST(Failsafe, HoldsItsPromisesInEveryCombination) {
  std::array<int, promises.size()> broken{};
  int cases = 0;
  for_every_input([&](const FailsafeInput& in) {
    const FailsafeOutput out = failsafe(in);
    ++cases;
    for (std::size_t i = 0; i < promises.size(); ++i) {
      broken[i] += promises[i](in, out) ? 1 : 0;
    }
  });
  EXPECT_EQ(cases, 6 * 3 * 64 * 8 * 256);
  for (std::size_t i = 0; i < promises.size(); ++i) {
    EXPECT_EQ(broken[i], 0) << "promise " << i;
  }
}

/// The way through all states, as it should go.
TEST(Failsafe, WayThroughAllStates) {
  FailsafeInput in{};
  in.state = DeviceState::starting;
  EXPECT_EQ(failsafe(in), (FailsafeOutput{DeviceState::starting, Heat::none}));
  in.started = true;
  EXPECT_EQ(failsafe(in), (FailsafeOutput{DeviceState::ready, Heat::none}));
  in.state = DeviceState::ready;
  in.arm = in.arm_edge = true;
  EXPECT_EQ(failsafe(in), (FailsafeOutput{DeviceState::arming, Heat::sense}));
  in.state = DeviceState::arming;
  in.arm_edge = false;
  EXPECT_EQ(failsafe(in), (FailsafeOutput{DeviceState::arming, Heat::sense}));
  in.checked = true;
  EXPECT_EQ(failsafe(in), (FailsafeOutput{DeviceState::ready, Heat::none}));
  in.passed = true;
  EXPECT_EQ(failsafe(in), (FailsafeOutput{DeviceState::running, Heat::run}));
  in.state = DeviceState::running;
  in.active = some_faults(0b111000);  // L, B, W
  EXPECT_EQ(failsafe(in), (FailsafeOutput{DeviceState::running, Heat::run}));
  in.active = in.latched = Fault::over_stress;
  in.safe = SafeState::hold;
  EXPECT_EQ(failsafe(in), (FailsafeOutput{DeviceState::fault, Heat::none}));
  in.may_hold = true;
  EXPECT_EQ(failsafe(in), (FailsafeOutput{DeviceState::stopping, Heat::hold}));
  in.state = DeviceState::stopping;
  in.active = {};
  EXPECT_EQ(failsafe(in), (FailsafeOutput{DeviceState::stopping, Heat::hold}));
  in.safe = SafeState::release;
  EXPECT_EQ(failsafe(in), (FailsafeOutput{DeviceState::stopping, Heat::release}));
  in.safe_over = true;
  EXPECT_EQ(failsafe(in), (FailsafeOutput{DeviceState::fault, Heat::none}));
  in.state = DeviceState::fault;
  in.latched = {};
  EXPECT_EQ(failsafe(in), (FailsafeOutput{DeviceState::ready, Heat::none}));
}

TEST(Failsafe, LatchingInEveryCombination) {
  for (const DeviceState state : states) {
    for (unsigned classes = 0; classes < 64; ++classes) {
      for (unsigned before = 0; before < 8; ++before) {
        for (const bool clear : {false, true}) {
          const FaultSet active = some_faults(classes);
          const FaultSet latched = some_faults(before);
          const FaultSet after = latch(latched, active, state, clear);
          const bool may_clear = clear && !is_heated(state);
          // A latched fault goes neither without the command nor while its condition lasts.
          ASSERT_TRUE((latched - after).empty() || may_clear);
          ASSERT_TRUE(((latched & active) - after).empty());
          if (may_clear) {
            ASSERT_TRUE((after - active).empty());
          }
          // Only faults that trip are latched, and all of these while the wire is heated.
          ASSERT_TRUE((after - tripping_faults).empty());
          if (is_heated(state)) {
            ASSERT_TRUE(((active & tripping_faults) - after).empty());
          }
          ASSERT_TRUE(((active & faults_of(FaultClass::F0)) - after).empty());
        }
      }
    }
  }
}

}  // namespace
}  // namespace smaservo::failsafe_test
