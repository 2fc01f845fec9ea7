#include "hal/replay/board.hpp"

#include <cmath>
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "model/units.hpp"
#include "tests/hal/replay/traces.hpp"

namespace smaservo::test::replay_board_test {
namespace {

constexpr double area_m2 = 2e-8;
constexpr double given_load_N = 0.75;

hal::ReplayBoard board_of(const TemporaryFolder& folder, std::string_view text,
                          const hal::TraceOptions& options = {}) {
  return {hal::TraceReader(folder.write("trace.csv", text), options), given_load_N, area_m2};
}

hal::Frame next(hal::ReplayBoard& board) {
  hal::Frame frame{};
  EXPECT_EQ(board.read(frame), hal::ReadStatus::frame);
  return frame;
}

TEST(ReplayBoard, FramesCarryTimeSequenceAndReadings) {
  const TemporaryFolder folder;
  hal::ReplayBoard board =
      board_of(folder,
               "time_ms,current_mA,voltage_V,load_N,strain_ref\n-1.5,100,2,0.5,0.04\n"
               "0.000001,110,2.1,0.6,0.03\n86400000,120,2.2,0.7,0.02\n");
  const hal::Frame first = next(board);
  EXPECT_EQ(first.time_ns, -1'500'000);
  EXPECT_EQ(first.sequence, 0U);
  EXPECT_DOUBLE_EQ(first.current_A, 0.1);
  EXPECT_DOUBLE_EQ(first.voltage_V, 2);
  EXPECT_DOUBLE_EQ(first.load_N, 0.5);
  EXPECT_EQ(board.row()[hal::Column::strain_ref], 0.04);
  const hal::Frame second = next(board);
  EXPECT_EQ(second.time_ns, 1);
  EXPECT_EQ(second.sequence, 1U);
  EXPECT_EQ(board.row()[hal::Column::strain_ref], 0.03);
  EXPECT_EQ(next(board).time_ns, 86'400'000'000'000);
}

TEST(ReplayBoard, LoadComesFromTheTraceOrElseIsGiven) {
  const TemporaryFolder folder;
  const auto load_N = [&](std::string_view text) {
    hal::ReplayBoard board = board_of(folder, text);
    return next(board).load_N;
  };
  EXPECT_DOUBLE_EQ(load_N("time_s,current_A,voltage_V,load_mN\n0,0,0,250\n"), 0.25);
  EXPECT_DOUBLE_EQ(load_N("time_s,current_A,voltage_V,stress_MPa\n0,0,0,100\n"), 2);
  EXPECT_DOUBLE_EQ(load_N("time_s,current_A,voltage_V\n0,0,0\n"), given_load_N);
  EXPECT_DOUBLE_EQ(load_N("time_s,current_A,voltage_V,stress_MPa,load_N\n0,0,0,100,1\n"), 1)
      << "what was measured is better than what was computed";
}

TEST(ReplayBoard, ADevicesTraceHasMoreReadings) {
  const TemporaryFolder folder;
  hal::TraceOptions options;
  options.device = true;
  hal::ReplayBoard board = board_of(folder,
                                    "time_s,fresh,sequence,current_A,voltage_V,load_N,supply_V,"
                                    "ambient_degC,driver_K,emergency_stop,driver_fault\n"
                                    "0,1,7,0.1,2,0.5,24,25,310,0,1\n"
                                    "0.001,0,7,,,,,,,0,0\n"
                                    "0.002,1,9,,2,0.5,,25,310,1,0\n",
                                    options);
  hal::Frame frame = next(board);
  EXPECT_EQ(frame.sequence, 7U);
  EXPECT_EQ(frame.supply_V, 24);
  EXPECT_DOUBLE_EQ(frame.ambient_K, room_K);
  EXPECT_EQ(frame.driver_K, 310);
  EXPECT_FALSE(frame.emergency_stop);
  EXPECT_TRUE(frame.driver_fault);
  EXPECT_EQ(board.read(frame), hal::ReadStatus::nothing);
  EXPECT_EQ(frame.time_ns, 1'000'000);
  frame = next(board);
  EXPECT_EQ(frame.sequence, 9U);
  EXPECT_TRUE(std::isnan(frame.current_A)) << "a reading that failed";
  EXPECT_TRUE(std::isnan(frame.supply_V));
  EXPECT_EQ(frame.voltage_V, 2);
  EXPECT_TRUE(frame.emergency_stop);
}

TEST(ReplayBoard, FlagsAndTimeAreNeverEmpty) {
  const TemporaryFolder folder;
  hal::TraceOptions options;
  options.device = true;
  for (const char* row : {"0,1,2,,1", "0,1,2,0,", ",1,2,0,1", "0,1,2,2,1"}) {
    hal::ReplayBoard board = board_of(
        folder, fmt::format("time_s,current_A,voltage_V,emergency_stop,fresh\n{}\n", row), options);
    hal::Frame frame{};
    EXPECT_THROW(board.read(frame), hal::TraceError) << row;
  }
}

TEST(ReplayBoard, WhatATraceDoesNotHaveIsNotRead) {
  const TemporaryFolder folder;
  hal::ReplayBoard board = board_of(folder, "time_s,current_A,voltage_V,supply_V\n0,1,2,24\n");
  const hal::Frame frame = next(board);
  EXPECT_TRUE(std::isnan(frame.supply_V)) << "a text, where no device is replayed";
  EXPECT_TRUE(std::isnan(frame.ambient_K));
  EXPECT_TRUE(std::isnan(frame.driver_K));
  EXPECT_FALSE(frame.emergency_stop);
}

TEST(ReplayBoard, TheEndIsForEver) {
  const TemporaryFolder folder;
  hal::ReplayBoard board = board_of(folder, "time_s,current_A,voltage_V\n0,1,2\n");
  next(board);
  hal::Frame frame{};
  frame.sequence = 8;
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(board.read(frame), hal::ReadStatus::end);
  }
  EXPECT_EQ(frame.sequence, 8U) << "no frame, nothing written";
  EXPECT_EQ(board.trace().rows(), 1U);
}

TEST(ReplayBoard, RemembersTheDriveUntilItIsSwitchedOff) {
  const TemporaryFolder folder;
  hal::ReplayBoard board = board_of(folder, "time_s,current_A,voltage_V\n0,1,2\n");
  EXPECT_EQ(board.last_command().current_A, 0);
  board.drive({.current_A = 0.2, .voltage_V = 4, .valid_until_ns = 5'000'000});
  EXPECT_EQ(board.last_command().current_A, 0.2);
  EXPECT_EQ(board.last_command().valid_until_ns, 5'000'000);
  for (int i = 0; i < 2; ++i) {
    board.safe_off();
    EXPECT_EQ(board.last_command().current_A, 0);
  }
}

TEST(ReplayBoard, NeedsTimeCurrentAndVoltage) {
  const TemporaryFolder folder;
  for (const char* header : {"current_A,voltage_V\n", "time_s,voltage_V\n", "time_s,current_A\n"}) {
    EXPECT_THROW(board_of(folder, header), hal::TraceError) << header;
  }
  hal::TraceOptions options;
  options.period_s = 0.001;
  hal::ReplayBoard board = board_of(folder, "current_A,voltage_V\n0,1\n0,1\n", options);
  next(board);
  EXPECT_EQ(next(board).time_ns, 1'000'000);
}

TEST(ReplayBoard, ASkippedRowIsALostFrame) {
  const TemporaryFolder folder;
  hal::TraceOptions options;
  options.lenient = true;
  hal::ReplayBoard board =
      board_of(folder, "time_s,current_A,voltage_V\n0,1,2\n1,x,2\n2,1,2\n3,1,2\n", options);
  EXPECT_EQ(next(board).sequence, 0U);
  EXPECT_EQ(next(board).sequence, 2U);
  EXPECT_EQ(next(board).sequence, 3U);
}

}  // namespace
}  // namespace smaservo::test::replay_board_test
