#pragma once
// How a step is timed.

#include <benchmark/benchmark.h>
#include <cstddef>
#include <string>

namespace smaservo::benchmarks {

/// The compiler must take the step's state for read and changed by others, as a caller's is.
template <class Step>
void run(Step& step) {
  step();
  benchmark::ClobberMemory();
}

template <class Make>
void time_step(benchmark::State& state, Make make) {
  auto step = make();
  benchmark::DoNotOptimize(&step);
  for (std::size_t i = 0; i < step.period(); ++i) {
    run(step);
  }
  for ([[maybe_unused]] auto _ : state) {
    run(step);
  }
  state.SetItemsProcessed(state.iterations());
}

/// Registers a kind of step under its name.
inline auto timing(const std::string& scalar) {
  return [scalar](const std::string& name, auto make) {
    benchmark::RegisterBenchmark((name + "/" + scalar).c_str(),
                                 [make](benchmark::State& state) { time_step(state, make); });
  };
}

void time_device_steps();
void time_paper_steps();
void time_wire_steps();

}  // namespace smaservo::benchmarks
