#include "host-sim/evaluate/closed_loop/loop_bench.hpp"

#include <algorithm>

#include "firmware/cycle.hpp"
#include "firmware/parameters/parameters.hpp"
#include "host-sim/evaluate/runs/electronics.hpp"

namespace smaservo::evaluate {
namespace {

constexpr std::int64_t period_ns = 1'000'000;

hal::SimSetup setup(const bench::WireUnit& unit, const LoopConditions& conditions,
                    std::uint64_t seed) {
  hal::SimSurroundings around;
  around.ambient_K = conditions.ambient_K;
  around.draught = conditions.draught;
  return {
      .period_ns = period_ns,
      .converter = converter(false),
      .sensors = sensors(unit.wire.wire.geometry, conditions.load_gain, conditions.resistance_gain),
      .load = conditions.load,
      .geometry = unit.wire.wire.geometry,
      .surroundings = around,
      .reads_supply = true,
      .reads_ambient = false,
      .reads_driver = false,
      .seed = seed};
}

std::unique_ptr<hal::SimulatedWire> wire(const bench::WireUnit& unit, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  return hal::make_simulated_wire(unit.family, unit.wire.wire, unit.structure, unit.scatter_K,
                                  random);
}

}  // namespace

Settings<double> loop_settings(const Wire<double>& wire) {
  Settings<double> s = default_settings<double>();
  s.wire = wire;
  s.limits.current_A = 0.4;
  s.limits.power_W = 10;
  s.limits.temperature_K = wire.limits.temperature_K;
  s.limits.max_strain = 0.06;
  s.limits.stress_Pa = wire.limits.stress_Pa;
  s.trips.current_A = 0.45;
  s.trips.temperature_K = wire.limits.temperature_K + 10;
  s.trips.max_strain = 0.08;
  s.trips.stress_Pa = 1.2 * wire.limits.stress_Pa;
  return s;
}

LoopBench::LoopBench(const bench::WireUnit& unit, const LoopConditions& conditions,
                     std::uint64_t seed)
    : board_(wire(unit, seed), setup(unit, conditions, seed)) {}

Inputs<double> LoopBench::read() {
  hal::Frame frame{};
  const hal::ReadStatus status = board_.read(frame);
  peak_K_ = std::max(peak_K_, board_.truth().hottest_K);
  return inputs_of<double>(frame, status);
}

void LoopBench::drive(double current_A) {
  board_.drive({current_A, 0, board_.now_ns() + leased_periods * period_ns});
}

}  // namespace smaservo::evaluate
