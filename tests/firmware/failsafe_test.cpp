#include "firmware/failsafe.hpp"

#include <array>
#include <gtest/gtest.h>

namespace smaservo {
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

/// Counts violations: an assertion for each of two million cases would be the whole time.
TEST(Failsafe, HoldsItsPromisesInEveryCombination) {
  int heated_with_f0_or_f1 = 0;
  int heat_outside_its_state = 0;
  int wrong_safe_state = 0;
  int safe_state_without_end = 0;
  int disarmed_but_heated = 0;
  int armed_against_a_block = 0;
  int out_of_fault_too_early = 0;
  int jumps = 0;
  int cases = 0;
  for_every_input([&](const FailsafeInput& in) {
    const FailsafeOutput out = failsafe(in);
    ++cases;
    const FaultSet all = in.active | in.latched;
    const bool heat = out.heat != Heat::none;
    const bool safe = out.heat == Heat::hold || out.heat == Heat::release;
    heated_with_f0_or_f1 += heat && (any(all, FaultClass::F0) || any(all, FaultClass::F1)) ? 1 : 0;
    heat_outside_its_state += heat != is_heated(out.state) ? 1 : 0;
    if (any(all, FaultClass::F2)) {
      const Heat configured = in.safe == SafeState::hold      ? Heat::hold
                              : in.safe == SafeState::release ? Heat::release
                                                              : Heat::none;
      wrong_safe_state += heat && out.heat != configured ? 1 : 0;
      wrong_safe_state += heat && !in.may_hold ? 1 : 0;
    }
    safe_state_without_end += safe && in.safe_over ? 1 : 0;
    disarmed_but_heated += heat && !in.arm ? 1 : 0;
    armed_against_a_block +=
        in.state == DeviceState::ready && heat && (in.blocked || !in.arm_edge) ? 1 : 0;
    armed_against_a_block += in.state == DeviceState::arming && out.state == DeviceState::running &&
                                     (in.blocked || !in.checked || !in.passed)
                                 ? 1
                                 : 0;
    out_of_fault_too_early +=
        in.state == DeviceState::fault && (heat || (!in.latched.empty() && out.state != in.state))
            ? 1
            : 0;
    jumps += out.state == DeviceState::running && in.state != DeviceState::running &&
                     in.state != DeviceState::arming
                 ? 1
                 : 0;
    jumps += out.state == DeviceState::stopping && in.state != DeviceState::running &&
                     in.state != DeviceState::stopping
                 ? 1
                 : 0;
  });
  EXPECT_EQ(cases, 6 * 3 * 64 * 8 * 256);
  EXPECT_EQ(heated_with_f0_or_f1, 0);
  EXPECT_EQ(heat_outside_its_state, 0);
  EXPECT_EQ(wrong_safe_state, 0);
  EXPECT_EQ(safe_state_without_end, 0);
  EXPECT_EQ(disarmed_but_heated, 0);
  EXPECT_EQ(armed_against_a_block, 0);
  EXPECT_EQ(out_of_fault_too_early, 0);
  EXPECT_EQ(jumps, 0);
}

/// What it does, beside what it must not do.
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
          // Nothing goes without the command, nor while its condition is there.
          ASSERT_TRUE((latched - after).empty() || may_clear);
          ASSERT_TRUE(((latched & active) - after).empty());
          if (may_clear) {
            ASSERT_TRUE((after - active).empty());
          }
          // Only what trips is ever latched, and while heated all of it.
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
}  // namespace smaservo
