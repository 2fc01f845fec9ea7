// Frames, commands and outputs between a port, a node and the loop.

#include "firmware/daemon/bus/bus_pump.hpp"

#include <array>
#include <deque>
#include <gtest/gtest.h>

namespace smaservo::test::bus_pump_test {
namespace {

class FakePort {
 public:
  std::deque<hal::CanFrame> in, out;
  bool full = false;
  hal::CanState now = hal::CanState::active;
  hal::CanState state() const { return now; }
  bool receive(hal::CanFrame& frame) {
    if (in.empty()) {
      return false;
    }
    frame = in.front();
    in.pop_front();
    return true;
  }
  bool send(const hal::CanFrame& frame) {
    if (!full) {
      out.push_back(frame);
    }
    return !full;
  }
};

/// Answers each frame with one of the next identifier; its set-point is the last identifier.
struct FakeNode {
  std::deque<hal::CanFrame> answers;
  double setpoint = 0;
  std::uint32_t setpoints_ = 0;
  std::uint64_t now_us = 0;
  int published = 0;
  bool arms = true;
  double published_A = 0;

  void receive(const hal::CanFrame& frame, std::uint64_t /*now_us*/) {
    setpoint = frame.id;
    ++setpoints_;
    hal::CanFrame answer = frame;
    ++answer.id;
    answers.push_back(answer);
  }
  void advance(std::uint64_t time_us) { now_us = time_us; }
  bool take(hal::CanFrame& frame) {
    if (answers.empty()) {
      return false;
    }
    frame = answers.front();
    answers.pop_front();
    return true;
  }
  Command<double> command() const {
    return {.fresh = true, .arm = arms, .mode = Mode::current, .setpoint = setpoint};
  }
  std::uint32_t setpoints() const { return setpoints_; }
  static FaultSet external() { return Fault::duplicate_node; }
  void publish(const Output<double>& output, const Inputs<double>& /*inputs*/, double /*dt_s*/) {
    ++published;
    published_A = output.drive_current_A;
  }
};

struct Rig {
  FakePort port;
  FakeNode node;
  daemon::BusCommandSource source{0.1};
  daemon::BusPump<FakePort, FakeNode> pump{port, node, source};
  void round(std::uint64_t now_us, FaultSet faults = {}) {
    pump.round(now_us, faults, [] {});
  }
};

// Some settings need a wire without current: the loop hears of the end of heating before them, and
// of its next beginning after them.
TEST(BusPump, SaysTheEndOfTheHeatBeforeNewSettings) {
  Rig rig;
  bool armed = false;
  const auto round = [&](std::uint64_t now_us) {
    rig.pump.round(now_us, {}, [&] {
      armed = rig.source.listen(1e-6 * static_cast<double>(now_us)).command.arm;
    });
  };
  round(1000);
  EXPECT_TRUE(rig.source.listen(1e-3).command.arm);
  rig.node.arms = false;
  round(2000);
  EXPECT_FALSE(armed) << "as the loop hears it when the settings come";
  rig.node.arms = true;
  round(3000);
  EXPECT_FALSE(armed);
  EXPECT_TRUE(rig.source.listen(3e-3).command.arm);
}

TEST(BusPump, CarriesBothWays) {
  Rig rig;
  rig.port.in = {{.id = 5}, {.id = 7}};
  Cycle cycle{};
  cycle.output.drive_current_A = 0.25;
  rig.source.tell(cycle, 1e-3);
  rig.source.tell(cycle, 1e-3);
  rig.round(1000);
  ASSERT_EQ(rig.port.out.size(), 2U);
  EXPECT_EQ(rig.port.out[1].id, 8U);
  EXPECT_EQ(rig.node.published, 2);
  EXPECT_EQ(rig.node.published_A, 0.25);
  EXPECT_EQ(rig.node.now_us, 1000U);
  const Heard<double> heard = rig.source.listen(0);
  EXPECT_EQ(heard.command.setpoint, 7);
  EXPECT_TRUE(heard.command.fresh);
  EXPECT_TRUE(heard.external.has(Fault::duplicate_node));
}

// The set-points of a cycle are all that have come since the loop last listened, in one round or in
// several.
TEST(BusPump, CountsTheSetpointsOfEachCycle) {
  Rig rig;
  EXPECT_EQ(rig.source.listen(0).setpoints, 0U);
  rig.port.in = {{.id = 1}, {.id = 2}};
  rig.round(0);
  rig.port.in = {{.id = 3}};
  rig.round(100);
  Heard<double> heard = rig.source.listen(0.001);
  EXPECT_EQ(heard.setpoints, 3U);
  EXPECT_EQ(heard.command.setpoint, 3);
  EXPECT_EQ(rig.source.listen(0.002).setpoints, 0U);
  rig.port.in = {{.id = 4}};
  rig.round(200);
  heard = rig.source.listen(0.003);
  EXPECT_EQ(heard.setpoints, 1U);
  EXPECT_EQ(heard.command.setpoint, 4);
}

TEST(BusPump, ACommandIsFreshOnceAndNobodyIsALostPartner) {
  Rig rig;
  EXPECT_FALSE(rig.source.listen(0).command.arm) << "before anybody has said so";
  rig.round(0);
  EXPECT_TRUE(rig.source.listen(0.001).command.fresh);
  EXPECT_FALSE(rig.source.listen(0.002).command.fresh);
  EXPECT_FALSE(rig.source.listen(0.1).external.has(Fault::bus_lost));
  EXPECT_TRUE(rig.source.listen(0.102).external.has(Fault::bus_lost));
  rig.round(200'000, Fault::bus_lost);
  EXPECT_TRUE(rig.source.listen(0.2).external.has(Fault::bus_lost)) << "as the port says";
  rig.round(201'000);
  EXPECT_FALSE(rig.source.listen(0.201).external.has(Fault::bus_lost));
}

TEST(BusPump, NeitherAFullQueueNorAFloodHoldsItUp) {
  Rig rig;
  rig.port.full = true;
  for (std::uint32_t i = 0; i < 1000; ++i) {
    rig.port.in.push_back({.id = i});
  }
  rig.round(0);
  EXPECT_EQ(rig.pump.frames(), 256U);
  rig.round(1);
  EXPECT_EQ(rig.node.now_us, 1U);
  EXPECT_EQ(rig.pump.frames(), 512U);
}

TEST(BusPump, WhatAFullQueueDoesNotTakeComesLaterInItsOrder) {
  Rig rig;
  rig.port.full = true;
  rig.port.in = {{.id = 1}, {.id = 3}, {.id = 5}};
  rig.round(0);
  EXPECT_EQ(rig.node.answers.size(), 2U) << "the node makes no more meanwhile";
  rig.round(10'000);
  EXPECT_EQ(rig.pump.dropped(), 0U);
  EXPECT_EQ(rig.pump.queue_full(), 2U);
  rig.port.full = false;
  rig.round(11'000);
  EXPECT_EQ(rig.pump.queue_full(), 2U);
  ASSERT_EQ(rig.port.out.size(), 3U);
  EXPECT_EQ(rig.port.out[0].id, 2U);
  EXPECT_EQ(rig.port.out[2].id, 6U);
  EXPECT_EQ(rig.pump.dropped(), 0U);
}

// A round sends at most four frames, so that the pump reads the port in between.
TEST(BusPump, MuchToSendIsSentInSeveralRounds) {
  Rig rig;
  for (std::uint32_t i = 0; i < 10; ++i) {
    rig.port.in.push_back({.id = 2 * i});
  }
  for (const std::size_t sent : std::array<std::size_t, 3>{4, 8, 10}) {
    rig.round(0);
    EXPECT_EQ(rig.port.out.size(), sent);
    EXPECT_EQ(rig.pump.has_more(), sent != 10);
  }
  for (std::uint32_t i = 0; i < 10; ++i) {
    EXPECT_EQ(rig.port.out[i].id, 2 * i + 1);
  }
  EXPECT_EQ(rig.pump.dropped(), 0U);
}

TEST(BusPump, ADeadBusDropsOldFramesAndOneThatIsDownAll) {
  Rig rig;
  rig.port.full = true;
  rig.port.in = {{.id = 1}, {.id = 3}, {.id = 5}};
  for (std::uint64_t t = 0; t <= 20'000; t += 1000) {
    rig.round(t);
  }
  EXPECT_EQ(rig.pump.dropped(), 1U);
  rig.port.now = hal::CanState::down;
  rig.round(21'000);
  EXPECT_EQ(rig.pump.dropped(), 3U);
  EXPECT_TRUE(rig.node.answers.empty());
}

}  // namespace
}  // namespace smaservo::test::bus_pump_test
