// The twin with faults, of every kind of board.

#include "hal/faulty_board.hpp"

#include <array>
#include <bit>
#include <cmath>
#include <gtest/gtest.h>
#include <memory>
#include <optional>

#include "hal/replay/board.hpp"
#include "hal/sim/board.hpp"
#include "hal/sim/lumped_wire.hpp"
#include "model/files/wire/wire_file.hpp"
#include "tests/hal/linux/devices/hands.hpp"
#include "tests/hal/replay/temporary_folder.hpp"

namespace smaservo::test::faulty_board_test {
namespace {

constexpr std::int64_t ms = 1'000'000;
constexpr int enough = 40;

// Each: a board, and the current that the last commands make it drive.

class Simulated {
 public:
  using Board = hal::SimBoard;
  Simulated()
      : board(
            {hal::make_lumped_wire(files::load_wire(std::string(files::default_wire)).wire),
             {.period_ns = ms,
              .converter = {.voltage_drive = false, .max_A = 0.5, .slew_A_s = 1e6, .lead_ohm = 0.5},
              .sensors = {.bits = 24,
                          .current_full_scale_A = 1,
                          .voltage_full_scale_V = 50,
                          .load_full_scale_N = 10,
                          .current_noise_A = 1e-4,
                          .voltage_noise_V = 1e-4,
                          .load_noise_N = 1e-4,
                          .load_gain = 1,
                          .resistance_gain = 1},
              .load = hal::ConstantLoad{150e6},
              .geometry = files::load_wire(std::string(files::default_wire)).wire.geometry,
              .surroundings = {},
              .reads_supply = true,
              .reads_ambient = true,
              .reads_driver = true,
              .seed = 1}}) {}
  double driven_A() {
    hal::Frame frame{};
    board.read(frame);
    return board.truth().current_A;
  }
  hal::SimBoard board;
};

class Replayed {
 public:
  using Board = hal::ReplayBoard;
  Replayed() : board(hal::TraceReader(folder_.write("trace.csv", rows()), {}), 1, 1e-8) {}
  double driven_A() const { return board.last_command().current_A; }

 private:
  static std::string rows() {
    std::string text = "time_ms,current_A,voltage_V,load_N\n";
    for (int i = 0; i < enough; ++i) {
      text += std::to_string(i) + ",0.1," + std::to_string(2 + i) + ",0.5\n";
    }
    return text;
  }
  TemporaryFolder folder_;

 public:
  hal::ReplayBoard board;
};

class OfLinux {
 public:
  using Board = hal::LinuxBoard;
  OfLinux() : board(parts(hands)) {}
  double driven_A() const { return hands.enabled ? hands.current_A : 0; }
  Hands hands;
  hal::LinuxBoard board;
};

template <class Backend>
class FaultyBoards : public testing::Test {
 protected:
  Backend backend;
  hal::FaultyBoard<typename Backend::Board> twin{backend.board};

  hal::Frame next() {
    hal::Frame frame{};
    EXPECT_EQ(twin.read(frame), hal::ReadStatus::frame);
    return frame;
  }
};
using Backends = testing::Types<Simulated, Replayed, OfLinux>;
TYPED_TEST_SUITE(FaultyBoards, Backends);

std::array<std::uint64_t, 6> bits(const hal::Frame& f) {
  return std::bit_cast<std::array<std::uint64_t, 6>>(
      std::array{f.current_A, f.voltage_V, f.load_N, f.supply_V, f.ambient_K, f.driver_K});
}

TYPED_TEST(FaultyBoards, WithoutFaultsAreTheBoard) {
  TypeParam alone;
  for (int i = 0; i < enough; ++i) {
    const hal::Frame frame = this->next();
    hal::Frame same{};
    ASSERT_EQ(alone.board.read(same), hal::ReadStatus::frame);
    EXPECT_EQ(bits(frame), bits(same)) << i;
    EXPECT_EQ(frame.sequence, same.sequence);
    EXPECT_FALSE(frame.emergency_stop || frame.driver_fault);
  }
}

TYPED_TEST(FaultyBoards, LoseOneReadingAndNoOther) {
  bool hal::BoardFaults::* const which[] = {&hal::BoardFaults::current_missing,
                                            &hal::BoardFaults::voltage_missing,
                                            &hal::BoardFaults::load_missing};
  for (std::size_t i = 0; i < 3; ++i) {
    this->twin.faults = {};
    this->twin.faults.*which[i] = true;
    const hal::Frame frame = this->next();
    const double readings[] = {frame.current_A, frame.voltage_V, frame.load_N};
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_EQ(std::isnan(readings[k]), k == i) << i << ' ' << k;
    }
  }
}

TYPED_TEST(FaultyBoards, LoseEachThirdFrame) {
  this->twin.faults.lose_every = 3;
  std::optional<std::uint32_t> before;
  for (int i = 1; i <= enough; ++i) {
    hal::Frame frame{};
    const hal::ReadStatus status = this->twin.read(frame);
    ASSERT_EQ(status, i % 3 == 0 ? hal::ReadStatus::nothing : hal::ReadStatus::frame) << i;
    if (status == hal::ReadStatus::frame) {
      if (before) {
        EXPECT_EQ(frame.sequence - *before, i % 3 == 1 ? 2U : 1U) << "lost frames leave a gap";
      }
      before = frame.sequence;
    }
  }
}

TYPED_TEST(FaultyBoards, StandStill) {
  const hal::Frame last = this->next();
  this->twin.faults.stuck = true;
  for (int i = 0; i < 5; ++i) {
    const hal::Frame frame = this->next();
    EXPECT_EQ(frame.sequence, last.sequence);
    EXPECT_EQ(bits(frame), bits(last));
    EXPECT_GT(frame.time_ns, last.time_ns) << "time goes on";
  }
  this->twin.faults.stuck = false;
  EXPECT_EQ(this->next().sequence, last.sequence + 6);
}

TYPED_TEST(FaultyBoards, PressTheStopAndFailTheDriver) {
  this->twin.faults.emergency_stop = true;
  EXPECT_TRUE(this->next().emergency_stop);
  this->twin.faults.driver_fault = true;
  this->twin.faults.lose_every = 1;
  hal::Frame frame{};
  EXPECT_EQ(this->twin.read(frame), hal::ReadStatus::nothing);
  EXPECT_TRUE(frame.emergency_stop && frame.driver_fault) << "inputs do not wait for a frame";
}

TYPED_TEST(FaultyBoards, ComeLate) {
  this->twin.faults.late_ns = 1000 * ms;
  const std::int64_t time_ns = this->next().time_ns;
  EXPECT_LE(time_ns, this->twin.now_ns() - 1000 * ms);
}

TYPED_TEST(FaultyBoards, HaveADeadDrive) {
  const auto drive = [&](double current_A) {
    this->twin.drive({current_A, 0, this->twin.now_ns() + 10 * ms});
  };
  this->next();
  drive(0.1);
  EXPECT_EQ(this->backend.driven_A(), 0.1);
  this->twin.faults.drive_dead = true;
  drive(0.2);
  EXPECT_EQ(this->backend.driven_A(), 0.1);
  this->twin.safe_off();
  EXPECT_EQ(this->backend.driven_A(), 0.1);
  this->twin.faults.drive_dead = false;
  this->twin.safe_off();
  EXPECT_EQ(this->backend.driven_A(), 0);
}

TYPED_TEST(FaultyBoards, EndForAsLongAsTheyAreTold) {
  this->twin.faults.ends = true;
  hal::Frame frame{};
  EXPECT_EQ(this->twin.read(frame), hal::ReadStatus::end);
  this->twin.faults.ends = false;
  EXPECT_EQ(this->next().sequence, 0U) << "the board was not asked";
}

TEST(FaultyLinuxBoard, KicksNoMore) {
  OfLinux backend;
  hal::FaultyBoard twin(backend.board);
  hal::Frame frame{};
  twin.read(frame);
  twin.drive({0.1, 0, 0});
  twin.kick();
  twin.faults.kick_dead = true;
  twin.kick();
  EXPECT_EQ(backend.hands.kicks, 1);
}

}  // namespace
}  // namespace smaservo::test::faulty_board_test
