#include "firmware/device/black_box.hpp"

#include <gtest/gtest.h>

#include "tests/firmware/safety/provokers.hpp"

namespace smaservo::black_box_test {
namespace {

using Box = BlackBox<double>;

void step(Rig& rig, Box& box) {
  rig.step();
  box.record(rig.inputs, rig.command, rig.out, Rig::dt_s);
}

TEST(BlackBox, TakesTheCycleOfTheFirstCause) {
  Rig rig = plain_rig();
  auto box = std::make_unique<Box>();
  rig.command.mode = Mode::strain;
  rig.command.setpoint = 0.025;
  rig.command.arm = true;
  for (int i = 0; i < 600; ++i) {
    step(rig, *box);
    ASSERT_FALSE(box->frame.taken);
  }
  rig.supply_V = 3;
  while (rig.out.first_cause == Fault::none) {
    step(rig, *box);
  }
  ASSERT_TRUE(box->frame.taken);
  EXPECT_EQ(box->frame.output.first_cause, Fault::supply_low);
  EXPECT_EQ(box->frame.output.first_cause_us, box->frame.output.time_us);
  EXPECT_EQ(box->frame.output.drive_current_A, 0);
  EXPECT_EQ(box->frame.inputs.supply_V, 3);
  EXPECT_EQ(box->frame.output.time_us, rig.out.time_us);
  EXPECT_EQ(box->frame.output.estimate.strain, rig.out.estimate.strain);
  EXPECT_EQ(box->frame.output.measurement.resistance_ohm, rig.out.measurement.resistance_ohm);
  EXPECT_EQ(box->frame.inputs.sample.voltage_V, rig.inputs.sample.voltage_V);
  EXPECT_EQ(box->frame.command.setpoint, rig.command.setpoint);
  EXPECT_EQ(box->frame.output.latched, rig.out.latched);
  // The whole box, with its ring, is frozen until the fault is cleared.
  const std::uint64_t time_us = rig.out.time_us;
  for (int i = 0; i < 100; ++i) {
    step(rig, *box);
  }
  EXPECT_EQ(box->frame.output.time_us, time_us);
  EXPECT_EQ(box->at(box->count - 1).time_ms, time_us / 1000);
  rig.supply_V = 24;
  rig.run(0.1);
  rig.command.clear_faults = true;
  step(rig, *box);
  EXPECT_FALSE(box->frame.taken);
}

TEST(BlackBox, KeepsTheLastFiveSeconds) {
  Rig rig = plain_rig();
  auto box = std::make_unique<Box>();
  rig.command.mode = Mode::strain;
  rig.command.arm = true;
  for (int i = 0; i < 8000; ++i) {
    rig.command.setpoint = i % 2000 < 1000 ? 0.02 : 0.03;
    step(rig, *box);
  }
  rig.tamper_inputs = [](Readings& in) { in.emergency_stop = true; };
  step(rig, *box);
  ASSERT_EQ(box->count, 500U);
  // The last line is that of the fault.
  EXPECT_EQ(box->at(499).time_ms, rig.out.time_us / 1000);
  EXPECT_EQ(box->at(499).state, DeviceState::fault);
  EXPECT_EQ(box->at(499).drive_current_A, 0);
  EXPECT_NEAR(box->at(499).time_ms - box->at(0).time_ms, 4990, 12);
  for (std::size_t i = 1; i < 499; ++i) {
    EXPECT_EQ(box->at(i).time_ms - box->at(i - 1).time_ms, 10U);
  }
}

TEST(BlackBox, HasItsRateByItsSize) {
  BlackBox<float, 50> box{};
  const Inputs<float> in{};
  Output<float> out{};
  for (int i = 0; i < 1000; ++i) {
    out.time_us += 1000;
    box.record(in, {}, out, 1e-3F);
  }
  EXPECT_EQ(box.count, 10U);
  EXPECT_EQ(box.at(9).time_ms - box.at(8).time_ms, 100U);
}

}  // namespace
}  // namespace smaservo::black_box_test
