// What a simulated board does between a command and the next frame.

#include "hal/sim/board.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>

#include "hal/sim/lumped_wire.hpp"
#include "model/files/wire/wire_file.hpp"

namespace smaservo::test::sim_board_test {
namespace {

constexpr std::int64_t ms = 1'000'000;
constexpr double no_slew = std::numeric_limits<double>::infinity();

const Wire<double>& wire() {
  static const Wire<double> preset = files::load_wire(std::string(files::default_wire)).wire;
  return preset;
}

hal::SimSetup clean_setup() {
  return {.period_ns = ms,
          .converter = {.voltage_drive = false, .max_A = 0.5, .slew_A_s = no_slew, .lead_ohm = 0.5},
          .sensors = {.bits = 24,
                      .current_full_scale_A = 1,
                      .voltage_full_scale_V = 50,
                      .load_full_scale_N = 10,
                      .current_noise_A = 0,
                      .voltage_noise_V = 0,
                      .load_noise_N = 0,
                      .load_gain = 1,
                      .resistance_gain = 1},
          .load = hal::ConstantLoad{150e6},
          .geometry = wire().geometry,
          .surroundings = {},
          .reads_supply = true,
          .reads_ambient = true,
          .reads_driver = true,
          .seed = 1};
}

hal::SimBoard board_with(const hal::SimSetup& setup) {
  return {hal::make_lumped_wire(wire()), setup};
}

hal::Frame next(hal::SimBoard& board) {
  hal::Frame frame{};
  EXPECT_EQ(board.read(frame), hal::ReadStatus::frame);
  return frame;
}

/// Drives this current for so many periods; the last frame.
hal::Frame driven(hal::SimBoard& board, double current_A, int periods) {
  hal::Frame frame{};
  for (int i = 0; i < periods; ++i) {
    board.drive(
        {.current_A = current_A, .voltage_V = 0, .valid_until_ns = board.now_ns() + 3 * ms});
    frame = next(board);
  }
  return frame;
}

bool same_bits(const hal::Frame& a, const hal::Frame& b) {
  const auto bits = [](const hal::Frame& f) {
    return std::bit_cast<std::array<std::uint64_t, 6>>(
        std::array{f.current_A, f.voltage_V, f.load_N, f.supply_V, f.ambient_K, f.driver_K});
  };
  return a.time_ns == b.time_ns && a.sequence == b.sequence && bits(a) == bits(b);
}

TEST(SimBoard, FramesFollowThePeriodAndOhmsLaw) {
  hal::SimBoard board = board_with(clean_setup());
  const hal::Frame first = next(board);
  EXPECT_EQ(first.time_ns, 0);
  EXPECT_EQ(first.sequence, 0U);
  EXPECT_EQ(first.current_A, 0);
  EXPECT_NEAR(first.load_N, 150e6 * wire().geometry.area_m2(), 2e-6);
  EXPECT_EQ(first.supply_V, 24);
  EXPECT_EQ(first.ambient_K, room_K);
  EXPECT_EQ(first.driver_K, 308.15);
  const hal::Frame later = driven(board, 0.05, 5);
  EXPECT_EQ(later.time_ns, 5 * ms);
  EXPECT_EQ(later.sequence, 5U);
  EXPECT_NEAR(later.current_A, 0.05, 1e-6);
  EXPECT_NEAR(later.voltage_V / later.current_A, board.wire().resistance_ohm(), 1e-3);
}

TEST(SimBoard, HeatIsALeaseOfTheLastCommand) {
  hal::SimBoard board = board_with(clean_setup());
  next(board);
  board.drive({.current_A = 0.1, .voltage_V = 0, .valid_until_ns = 3 * ms});
  std::array<double, 5> currents{};
  for (double& current_A : currents) {
    current_A = next(board).current_A;
  }
  EXPECT_GT(currents[2], 0.09);
  EXPECT_EQ(currents[3], 0) << "nobody renewed it";
  driven(board, 0.1, 2);
  board.safe_off();
  EXPECT_EQ(next(board).current_A, 0);
}

TEST(SimBoard, SameSeedSameBits) {
  for (const std::uint64_t seed : {1U, 2U}) {
    hal::SimSetup setup = clean_setup();
    setup.seed = seed;
    setup.sensors.current_noise_A = setup.sensors.voltage_noise_V = setup.sensors.load_noise_N =
        1e-4;
    setup.load = hal::VaryingLoad{150e6, 20e6, 0.5, 10e6, 50e6};
    hal::SimBoard a = board_with(setup);
    hal::SimBoard b = board_with(setup);
    setup.seed += 10;
    hal::SimBoard other = board_with(setup);
    int different = 0;
    for (int i = 0; i < 300; ++i) {
      const hal::Frame frame = driven(a, 0.1, 1);
      ASSERT_TRUE(same_bits(frame, driven(b, 0.1, 1)));
      different += same_bits(frame, driven(other, 0.1, 1)) ? 0 : 1;
    }
    EXPECT_EQ(different, 300);
  }
}

TEST(SensorNoise, IsWhiteNormalAndBounded) {
  hal::SensorNoise noise(5);
  constexpr int n = 200'000;
  double sum = 0;
  double squares = 0;
  double neighbours = 0;
  double last = 0;
  double max = 0;
  for (int i = 0; i < n; ++i) {
    const double x = noise();
    sum += x;
    squares += x * x;
    neighbours += x * last;
    last = x;
    max = std::max(max, std::abs(x));
  }
  // Five standard deviations of each estimate.
  EXPECT_NEAR(sum / n, 0, 5 / std::sqrt(n));
  EXPECT_NEAR(squares / n, 1, 5 * std::sqrt(1.7 / n));
  EXPECT_NEAR(neighbours / n, 0, 5 / std::sqrt(n));
  EXPECT_GT(max, 3);
  EXPECT_LE(max, 2 * std::sqrt(3.0));
}

TEST(SensorNoise, HasTheSameBitsEverywhere) {
  // splitmix64 from 0 begins with E220A8397B1DCDAF, as its authors publish it.
  hal::SensorNoise noise(0);
  const double sum = 0xE220 + 0xA839 + 0x7B1D + 0xCDAF;
  EXPECT_EQ(noise(), (sum - 131070) * (1 / 37837.22700343));
}

TEST(SimBoard, TheConverterHasLimits) {
  hal::SimSetup setup = clean_setup();
  setup.converter.max_A = 0.2;
  setup.converter.slew_A_s = 50;
  hal::SimBoard board = board_with(setup);
  next(board);
  EXPECT_NEAR(driven(board, 1, 1).current_A, 0.05, 1e-6) << "slew";
  EXPECT_NEAR(driven(board, 1, 5).current_A, 0.2, 1e-6) << "saturation";
  board.surroundings.supply_V = 2;
  const double path_ohm = board.wire().resistance_ohm() + 0.5;
  EXPECT_NEAR(driven(board, 1, 3).current_A, 2 / path_ohm, 2e-3) << "compliance";
  EXPECT_EQ(driven(board, 0, 1).current_A, 0) << "off is off at once";
  EXPECT_EQ(driven(board, -1, 1).current_A, 0) << "nothing cools by current";
}

TEST(SimBoard, AVoltageDrivesWhatTheResistanceLets) {
  hal::SimSetup setup = clean_setup();
  setup.converter.voltage_drive = true;
  hal::SimBoard board = board_with(setup);
  next(board);
  board.drive({.current_A = 9, .voltage_V = 1, .valid_until_ns = ms});
  const double ohm = board.wire().resistance_ohm();
  EXPECT_NEAR(next(board).current_A, 1 / (ohm + 0.5), 1e-6);
}

TEST(SimBoard, BrokenWiresCarryNothing) {
  hal::SimBoard board = board_with(clean_setup());
  next(board);
  driven(board, 0.1, 3);
  board.faults().circuit = hal::Circuit::broken;
  hal::Frame frame = driven(board, 0.1, 1);
  EXPECT_EQ(frame.current_A, 0);
  EXPECT_NEAR(frame.voltage_V, 24, 1e-5) << "the sense leads see the converter against its end";
  EXPECT_EQ(frame.load_N, 0);
  EXPECT_EQ(board.truth().stress_Pa, 0);
  board.faults().circuit = hal::Circuit::open;
  frame = driven(board, 0.1, 1);
  EXPECT_EQ(frame.current_A, 0);
  EXPECT_EQ(frame.voltage_V, 0);
  EXPECT_GT(frame.load_N, 0.5) << "the wire still holds";
  board.faults().circuit = hal::Circuit::shorted;
  board.faults().bridged_share = 0.25;
  frame = driven(board, 0.1, 1);
  EXPECT_NEAR(frame.voltage_V / frame.current_A, 0.75 * board.wire().resistance_ohm(), 1e-3);
}

TEST(SimBoard, SensorsLieAsTheyAreTold) {
  hal::SimBoard board = board_with(clean_setup());
  next(board);
  const hal::Frame good = driven(board, 0.1, 3);
  const auto voltage = [&](hal::SensorFault fault, double amount) {
    board.faults().sensors[static_cast<std::size_t>(hal::Reading::voltage)] = {fault, amount};
    return driven(board, 0.1, 1).voltage_V;
  };
  EXPECT_EQ(voltage(hal::SensorFault::stuck, 0), good.voltage_V);
  EXPECT_TRUE(std::isnan(voltage(hal::SensorFault::missing, 0)));
  EXPECT_NEAR(voltage(hal::SensorFault::offset, 0.5), 0.1 * board.wire().resistance_ohm() + 0.5,
              1e-3);
  EXPECT_NEAR(voltage(hal::SensorFault::gain, 1.5), 0.15 * board.wire().resistance_ohm(), 1e-3);
  EXPECT_EQ(voltage(hal::SensorFault::value, 0), 0);
  EXPECT_NE(voltage(hal::SensorFault::noise, 1), voltage(hal::SensorFault::noise, 1));
  EXPECT_NEAR(voltage(hal::SensorFault::none, 0), 0.1 * board.wire().resistance_ohm(), 1e-3);
}

TEST(SimBoard, LostFramesLeaveAGapInTheSequence) {
  hal::SimBoard board = board_with(clean_setup());
  next(board);
  board.faults().lost_share = 1;
  hal::Frame frame{};
  for (int i = 1; i <= 3; ++i) {
    EXPECT_EQ(board.read(frame), hal::ReadStatus::nothing);
    EXPECT_EQ(frame.time_ns, i * ms);
  }
  board.faults().lost_share = 0.5;
  int lost = 0;
  for (int i = 0; i < 1000; ++i) {
    lost += board.read(frame) == hal::ReadStatus::nothing ? 1 : 0;
  }
  EXPECT_NEAR(lost, 500, 80);
  board.faults().lost_share = 0;
  EXPECT_EQ(next(board).sequence, 1004U);
}

TEST(SimBoard, LoadSlipAndDraughtReachTheWire) {
  hal::SimBoard board = board_with(clean_setup());
  next(board);
  const double before = board.truth().strain;
  board.surroundings.slip = 0.01;
  EXPECT_NEAR(board.truth().strain, before + 0.01, 1e-12);
  board.surroundings.added_stress_Pa = 50e6;
  next(board);
  EXPECT_EQ(board.truth().stress_Pa, 200e6);
  driven(board, 0.1, 3000);
  const double still_K = board.truth().hottest_K;
  board.surroundings.draught = 2;
  driven(board, 0.1, 3000);
  EXPECT_LT(board.truth().hottest_K, still_K - 10);
}

TEST(SimBoard, AStopPullsWhereTheLoadAloneWouldLetTheWireBeShorter) {
  hal::SimSetup setup = clean_setup();
  hal::SimBoard free = board_with(setup);
  setup.surroundings.stop_strain = 0.025;
  hal::SimBoard stopped = board_with(setup);
  double greatest_Pa = 0;
  for (int i = 0; i < 3000; ++i) {
    const double current_A = i < 1500 ? 0.25 : 0;
    driven(free, current_A, 1);
    driven(stopped, current_A, 1);
    const hal::SimTruth truth = stopped.truth();
    ASSERT_GE(truth.strain, 0.025 - 1e-8) << i;
    ASSERT_GE(truth.stress_Pa, 150e6) << i;
    greatest_Pa = std::max(greatest_Pa, truth.stress_Pa);
    if (truth.strain > 0.025 + 1e-8) {
      ASSERT_EQ(truth.stress_Pa, 150e6) << i << ": it pushes";
    }
    if (greatest_Pa == 150e6) {
      ASSERT_EQ(truth.strain, free.truth().strain) << i << ": it acts before the wire is there";
    }
  }
  EXPECT_LT(free.truth().hottest_K, 330) << "cold again";
  EXPECT_GT(greatest_Pa, 250e6);
  EXPECT_EQ(stopped.truth().stress_Pa, 150e6) << "what has cooled is free again";
}

TEST(SimBoard, LongPeriodsAreMadeOfSubsteps) {
  hal::SimSetup setup = clean_setup();
  hal::SimBoard fine = board_with(setup);
  setup.period_ns = 4 * ms;
  hal::SimBoard coarse = board_with(setup);
  EXPECT_EQ(coarse.parts(), 0) << "none before the first frame";
  next(fine);
  next(coarse);
  EXPECT_EQ(coarse.parts(), 4);
  driven(fine, 0.15, 40);
  for (int i = 0; i < 10; ++i) {
    coarse.drive({.current_A = 0.15, .voltage_V = 0, .valid_until_ns = coarse.now_ns() + 4 * ms});
    next(coarse);
  }
  EXPECT_EQ(fine.now_ns(), coarse.now_ns());
  EXPECT_EQ(fine.truth().hottest_K, coarse.truth().hottest_K);
}

}  // namespace
}  // namespace smaservo::test::sim_board_test
