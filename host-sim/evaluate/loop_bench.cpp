#include "host-sim/evaluate/loop_bench.hpp"

#include <algorithm>
#include <limits>

#include "firmware/board_io.hpp"

namespace smaservo {
namespace {

constexpr std::int64_t period_ns = 1'000'000;

SimSetup setup(const Unit& unit, const LoopConditions& conditions, std::uint64_t seed) {
  SimSurroundings around;
  around.ambient_K = conditions.ambient_K;
  around.draught = conditions.draught;
  const double area_m2 = unit.wire.wire.geometry.area_m2();
  return {.period_ns = period_ns,
          .converter = {.voltage_drive = false,
                        .greatest_A = 0.5,
                        .slew_A_s = std::numeric_limits<double>::infinity(),
                        .lead_ohm = 0.1},
          .sensors = {.bits = 16,
                      .current_full_scale_A = 0.5,
                      .voltage_full_scale_V = 20,
                      .load_full_scale_N = 5,
                      .current_noise_A = 10e-6,
                      .voltage_noise_V = 0.3e-3,
                      .load_noise_N = 0.5e6 * area_m2,
                      .load_gain = conditions.load_gain,
                      .resistance_gain = conditions.resistance_gain},
          .load = conditions.load,
          .geometry = unit.wire.wire.geometry,
          .surroundings = around,
          .reads_supply = true,
          .reads_ambient = false,
          .reads_driver = false,
          .seed = seed};
}

std::unique_ptr<SimulatedWire> wire(const Unit& unit, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  return make_simulated_wire(unit.family, unit.wire.wire, unit.sublayers, unit.scatter_K, random);
}

}  // namespace

/// The measurement's noise, the converter's range and the maker's limits of a wire with 0.1 m.
Settings<double> loop_settings(const Wire<double>& wire) {
  Settings<double> s{};
  s.identity = {1, 1};
  s.timing = {1e-3, 0.1, 0.005};
  s.wire = wire;
  s.measuring = {.current_offset_A = 0,
                 .voltage_offset_V = 0,
                 .load_offset_N = 0,
                 .load_gain = 1,
                 .current_noise_A = 1e-5,
                 .voltage_noise_V = 3e-4,
                 .lead_resistance_ohm = 0,
                 .constant_load_N = 0,
                 .has_load_cell = true,
                 .current_full_scale_A = 0.5,
                 .voltage_full_scale_V = 20};
  s.drive = {DriveKind::current, 0, 0, 5, 30};
  s.strain = {0, 0, 0, 0.005, 1, 0, 0.05, 1, 1e-4};
  s.temperature = {0.05, 1, 0, 0.005, 1, 0, 0.05, 1, 0};
  s.resistance = {1, 1, 0, 0.005, 1, 0, 0.05, 1, 0};
  s.force = {20, 1, 0, 0.005, 1, 0, 0.05, 1, 0};
  s.feed_forward_s = 0.01;
  s.transfer_s = 0.01;
  s.trajectory = {0.35, 1};
  s.limits = {.least_current_A = 0.02,
              .current_A = 0.4,
              .power_W = 10,
              .temperature_K = wire.limits.temperature_K,
              .hot_spot_K = 15,
              .least_strain = 0,
              .greatest_strain = 0.06,
              .stress_Pa = wire.limits.stress_Pa,
              .duty = 1,
              .duty_window_s = 10};
  s.trips = {.current_A = 0.45,
             .temperature_K = wire.limits.temperature_K + 10,
             .stress_Pa = 1.2 * wire.limits.stress_Pa,
             .slack_Pa = 1e6,
             .least_strain = -0.005,
             .greatest_strain = 0.07,
             .following_error = 0.02,
             .following_s = 5,
             .heating_rate_K_s = 1e4,
             .resistance_low = 0.8,
             .resistance_high = 1.2,
             .current_offset_A = 0.002,
             .least_ambient_K = 253.15,
             .greatest_ambient_K = 333.15,
             .driver_K = 358.15,
             .drift = 0.05,
             .cycles = 100000};
  s.safe = {SafeState::off, 0, 0.01};
  s.profile = {12, 5, 1.5};
  s.axis = {0.04};
  return s;
}

LoopBench::LoopBench(const Unit& unit, const LoopConditions& conditions, std::uint64_t seed)
    : board_(wire(unit, seed), setup(unit, conditions, seed)) {}

Inputs<double> LoopBench::read() {
  Frame frame{};
  const ReadStatus status = board_.read(frame);
  peak_K_ = std::max(peak_K_, board_.truth().hottest_K);
  return inputs_of<double>(frame, status);
}

void LoopBench::drive(double current_A) {
  board_.drive({current_A, 0, board_.time_ns() + 3 * period_ns});
}

}  // namespace smaservo
