// Times the steps of model and observer.

#include <benchmark/benchmark.h>
#include <string>

#include "tests/bench/main.hpp"
#include "tests/bench/steps.hpp"
#include "tests/bench/time_step.hpp"

namespace smaservo::benchmarks {
namespace {

/// Paper 000 simulates 47.3 s at 0.1 ms in 17.2 s: 473 000 points of the kinetics alone.
template <class S>
void time_points(benchmark::State& state) {
  constexpr int points = 473'000;
  CutStep<S> step;
  benchmark::DoNotOptimize(&step);
  for ([[maybe_unused]] auto _ : state) {
    for (int i = 0; i < points; ++i) {
      run(step);
    }
  }
  state.SetItemsProcessed(state.iterations() * points);
}

template <class S>
void add_all(const std::string& scalar) {
  for_each_step<S>(timing(scalar));
  benchmark::RegisterBenchmark(("ModelPoints473000/" + scalar).c_str(), &time_points<S>)
      ->Unit(benchmark::kMillisecond);
}

template <class S>
void add_error(const std::string& name, Split<S> (*inverse)(const IhypShape<S>&, S)) {
  benchmark::RegisterBenchmark(name.c_str(), [inverse](benchmark::State& state) {
    for ([[maybe_unused]] auto _ : state) {
      state.counters["worst_relative_error"] = worst_relative_error<S>(inverse);
    }
  })->Iterations(1);
}

template <class S>
void add_errors(const std::string& scalar) {
  add_error<S>("ihyp_inverse_error/" + scalar, &ihyp_fraction<S>);
  add_error<S>("ihyp_inverse_cardano_error/" + scalar, &cardano_fraction<S>);
  add_error<S>("ihyp_inverse_newton_error/" + scalar, &newton_fraction<S>);
}

}  // namespace

void register_benchmarks() {
  add_all<float>("float");
  add_all<double>("double");
  time_device_steps();
  time_paper_steps();
  time_wire_steps();
  add_errors<float>("float");
  add_errors<double>("double");
}

}  // namespace smaservo::benchmarks
