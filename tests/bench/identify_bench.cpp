// How long the identification of a wire takes, by the number of runs and of threads.

#include <benchmark/benchmark.h>
#include <vector>

#include "host-sim/evaluate/runs/calibrate.hpp"
#include "host-sim/evaluate/runs/runs.hpp"
#include "host-sim/identify/fit/fit.hpp"

namespace smaservo {
namespace {

void identify(benchmark::State& state) {
  const bench::WireUnit unit = bench::random_unit(hal::Family::ihyp, 1);
  const auto count = static_cast<std::size_t>(state.range(0));
  std::vector<identify::Run> runs;
  runs.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    // Spread over all stresses, however many there are.
    runs.push_back(evaluate::calibration_measurement(
        unit, i * evaluate::calibration_stresses_MPa.size() / count));
  }
  identify::FitOptions options;
  options.threads = static_cast<int>(state.range(1));
  while (state.KeepRunning()) {
    benchmark::DoNotOptimize(identify::fit_wire(unit.type_file(), runs, options));
  }
}

BENCHMARK(identify)
    ->ArgNames({"runs", "threads"})
    ->ArgsProduct({{1, 2, 4, 8}, {1, 2}})
    ->Iterations(1)
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace smaservo

BENCHMARK_MAIN();
