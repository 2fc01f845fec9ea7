// The device's step closed on simulated wires: steps in a second of one core. At 1 kHz a thousandth
// of that is the factor over real time.

#include <benchmark/benchmark.h>
#include <random>
#include <string>

#include "firmware/bench/closed_loop.hpp"
#include "tests/bench/main.hpp"
#include "tests/places.hpp"

namespace smaservo::benchmarks {
namespace {

/// A wire that goes from strain to strain for 60 s, under 200 MPa.
bench::ClosedLoopScenario scenario(bench::PlantFamily family) {
  bench::ClosedLoopScenario s =
      bench::load_closed_loop(test::source_folder() + "/host-sim/scenarios/staircase.toml");
  s.plant.family = family;
  s.program.resize(1);
  s.program.front().seconds = 0.5;
  std::mt19937_64 random(1);
  for (int i = 0; i < 60; ++i) {
    bench::CommandStretch step{};
    step.command.arm = true;
    step.command.mode = Mode::strain;
    step.command.setpoint = step.end =
        0.005 + 0.03 * static_cast<double>(random() >> 11U) * 0x1p-53;
    step.seconds = 1;
    s.program.push_back(step);
  }
  s.duration_s = 60.5;
  return s;
}

void time_loop(benchmark::State& state, const bench::ClosedLoopScenario& loop_scenario) {
  std::int64_t steps = 0;
  for ([[maybe_unused]] auto _ : state) {
    bench::ClosedLoop loop(loop_scenario);
    while (loop.step()) {
      ++steps;
    }
    benchmark::DoNotOptimize(loop.cycle());
  }
  state.SetItemsProcessed(steps);
  const double simulated_s =
      static_cast<double>(steps) * 1e-9 * static_cast<double>(loop_scenario.board.period_ns);
  state.counters["times_real_time"] = benchmark::Counter(simulated_s, benchmark::Counter::kIsRate);
}

}  // namespace

void register_benchmarks() {
  for (const bench::PlantFamily family :
       {bench::PlantFamily::lumped, bench::PlantFamily::ihyp, bench::PlantFamily::sublayers}) {
    const std::string name = "closed_loop/" + std::string(bench::plant_name(family));
    benchmark::RegisterBenchmark(name.c_str(), [s = scenario(family)](benchmark::State& state) {
      time_loop(state, s);
    })->Unit(benchmark::kMillisecond);
  }
}

}  // namespace smaservo::benchmarks
