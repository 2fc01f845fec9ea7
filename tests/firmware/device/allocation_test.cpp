// Nothing that runs beside or in the loop takes memory from the heap.

#include <gtest/gtest.h>
#include <memory>
#include <set>

#include "firmware/device/adopt.hpp"
#include "firmware/device/black_box.hpp"
#include "firmware/parameters/staging.hpp"
#include "tests/firmware/device/allocation_trap.hpp"
#include "tests/firmware/device/random_use.hpp"
#include "tests/firmware/parameters/random_settings.hpp"

namespace smaservo::test::allocation_test {
namespace {

/// A device in random use whose owner changes parameters all the time.
template <class S>
class Owner {
 public:
  explicit Owner(unsigned seed) : use_(seed), random_(seed) {}

  /// What was allocated in this step, and what was between it and the next.
  int step() {
    const Parameter<S>& row = parameters<S>[use_.below(parameter_count)];
    const Value value = random_value(row, row.get(staging_.staged()), random_);
    const bool stages = use_.chance(0.01);
    const std::uint32_t then = use_.below(600);
    use_.next(state_->last);
    const AllocationTrap trap;
    const Output<S> out =
        Device<S>::step(*prepared_, *state_, use_.inputs, use_.command, use_.dt_s);
    box_->record(use_.inputs, use_.command, out, use_.dt_s);
    const bool enabled = is_heated(out.state);
    if (stages) {
      staging_.stage(row.key, value, enabled);
    }
    change(then, enabled);
    const int caught = AllocationTrap::caught();
    note(out);
    return caught;
  }
  void restart_if_idle() {
    if (use_.idle()) {
      *state_ = Device<S>::start();
      use_.rest();
    }
  }

  std::set<DeviceState> states;
  std::set<Mode> modes;  ///< that gave a current
  FaultSet faults;
  int adopted = 0, reverted = 0, frozen = 0;

 private:
  static Settings<S> settings_that_hold() {
    Settings<S> settings = test_settings<S>();
    settings.safe = {SafeState::hold, S(0.5), S(0.01)};
    return stored_settings<S>(settings);
  }
  void change(std::uint32_t then, bool enabled) {
    bool changed = false;
    if (then == 0) {
      changed = staging_.apply(enabled).ok();
    } else if (then == 1) {
      changed = staging_.try_for(S(0.1)).ok();
    } else if (then == 2) {
      staging_.discard();
    } else if (then == 3) {
      staging_.commit();
    }
    if (staging_.tick(use_.dt_s)) {
      changed = true;
      ++reverted;
    }
    if (changed) {
      *next_ = prepare(staging_.active());
      adopt(*prepared_, *next_, *state_);
      *prepared_ = *next_;
      ++adopted;
    }
  }
  void note(const Output<S>& out) {
    states.insert(out.state);
    if (out.drive_current_A > S(0)) {
      modes.insert(out.mode);
    }
    faults = faults | out.active;
    frozen += box_->frame.taken ? 1 : 0;
  }

  using State = typename Device<S>::State;

  RandomUse<S> use_;
  std::mt19937 random_;
  OwnSettings<S> settings_{settings_that_hold()};
  Staging<S> staging_{settings_};
  std::unique_ptr<Prepared<S>> prepared_ =
      std::make_unique<Prepared<S>>(prepare(staging_.active()));
  std::unique_ptr<Prepared<S>> next_ = std::make_unique<Prepared<S>>(*prepared_);
  std::unique_ptr<State> state_ = std::make_unique<State>(Device<S>::start());
  std::unique_ptr<BlackBox<S>> box_ = std::make_unique<BlackBox<S>>();
};

template <class S>
void expect_no_allocation() {
  std::set<DeviceState> states;
  std::set<Mode> modes;
  FaultSet faults;
  int adopted = 0, reverted = 0, frozen = 0;
  // One owner may commit settings with which the device never does some of it again.
  for (const unsigned seed : {21U, 22U, 23U, 24U}) {
    Owner<S> owner(seed);
    for (int i = 0; i < 60000; ++i) {
      ASSERT_EQ(owner.step(), 0) << "seed " << seed << ", step " << i;
      owner.restart_if_idle();
    }
    states.merge(owner.states);
    modes.merge(owner.modes);
    faults = faults | owner.faults;
    adopted += owner.adopted;
    reverted += owner.reverted;
    frozen += owner.frozen;
  }
  // They have been everywhere.
  EXPECT_EQ(states.size(), device_state_count);
  EXPECT_GE(modes.size(), mode_count - 1U);
  EXPECT_GT(std::popcount(faults.bits()), 30);
  EXPECT_GT(adopted, 50);
  EXPECT_GT(reverted, 10);
  EXPECT_GT(frozen, 1000);
}

TEST(Allocation, NoneInDouble) {
  expect_no_allocation<double>();
}

TEST(Allocation, NoneInFloat) {
  expect_no_allocation<float>();
}

}  // namespace
}  // namespace smaservo::test::allocation_test
