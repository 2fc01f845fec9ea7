// What a board of Linux devices makes of its parts.

#include "hal/linux/board.hpp"

#include <cmath>
#include <gtest/gtest.h>

#include "tests/hal/linux/devices/hands.hpp"

namespace smaservo::test::linux_board_test {
namespace {

TEST(LinuxBoard, CodesBecomeReadingsByTheCalibration) {
  Hands hands;
  hal::LinuxBoard board(parts(hands));
  hal::Frame frame{};
  ASSERT_EQ(board.read(frame), hal::ReadStatus::frame);
  EXPECT_DOUBLE_EQ(frame.current_A, 0.1);
  EXPECT_DOUBLE_EQ(frame.voltage_V, 1.5);
  EXPECT_DOUBLE_EQ(frame.load_N, 0);
  EXPECT_TRUE(std::isnan(frame.supply_V));
}

TEST(LinuxBoard, TheSwitchClosesLastAndOpensFirst) {
  Hands hands;
  hal::LinuxBoard board(parts(hands));
  hands.order.clear();
  board.drive({0.1, 0, 0});
  EXPECT_EQ(hands.order, (std::vector<std::string>{"put", "on"}));
  hands.order.clear();
  board.drive({0.2, 0, 0});
  EXPECT_EQ(hands.order, (std::vector<std::string>{"put"}));
  hands.order.clear();
  board.drive({});
  EXPECT_EQ(hands.order, (std::vector<std::string>{"off", "put"}));
}

TEST(LinuxBoard, WhatFailsEndsTheHeatAndTheKicks) {
  Hands hands;
  hal::LinuxBoard board(parts(hands));
  hal::Frame frame{};
  board.read(frame);
  board.drive({0.1, 0, 0});
  board.kick();
  EXPECT_EQ(hands.kicks, 1);
  hands.takes = false;
  board.drive({0.3, 0, 0});
  board.kick();
  EXPECT_FALSE(hands.enabled) << "the second switch, where the first one does not answer";
  EXPECT_EQ(hands.kicks, 1);
  EXPECT_EQ(board.read(frame), hal::ReadStatus::frame);
  EXPECT_TRUE(frame.driver_fault);
  hands.takes = true;
  board.drive({0.1, 0, 0});
  EXPECT_TRUE(hands.enabled);
  hands.stop = true;
  hands.comes = false;
  EXPECT_EQ(board.read(frame), hal::ReadStatus::nothing);
  board.drive({0.1, 0, 0});
  board.kick();
  EXPECT_EQ(hands.current_A, 0) << "the stop does not wait for a frame";
  EXPECT_FALSE(hands.enabled);
  EXPECT_EQ(hands.kicks, 1);
}

}  // namespace
}  // namespace smaservo::test::linux_board_test
