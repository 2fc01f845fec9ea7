// What the steps of files need, whatever they run on: operations of the algorithm, without loads,
// branches and calls, in lines like those of bench_steps and bench_fixed.
//   count_operations FILE...

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <string>

#include "tests/bench/counted.hpp"
#include "tests/mcu/model_triangle.hpp"
#include "tests/mcu/whole_step_file.hpp"

namespace smaservo::mcu {
namespace {

using S = benchmarks::Counted;

template <class Step>
std::uint64_t operations(Step&& step) {
  const benchmarks::Operations before = S::operations;
  step();
  return (S::operations - before).all();
}

struct Counts {
  std::uint64_t steps = 0, sum = 0, worst = 0, worst_at = 0;

  void add(std::uint64_t own) {
    sum += own;
    worst_at = worst < own ? steps : worst_at;
    worst = std::max(worst, own);
    ++steps;
  }
  void print(const char* name, const std::string& file) const {
    const auto whole = [](std::uint64_t n) { return static_cast<unsigned long long>(n); };
    std::printf("%s %s %llu %llu %llu %llu\n", name, file.c_str(), whole(steps),
                whole(steps == 0 ? 0 : sum / steps), whole(worst), whole(worst_at));
  }
};

bool count_file(const std::string& path) {
  WholeStepFile file(path);
  const auto settings = file.settings<S>();
  if (!settings) {
    return false;
  }
  const Prepared<S> prepared = prepare(*settings);
  static bool first = true;
  if (first) {
    Counts model;
    model_triangle(prepared, [&](auto step) { model.add(operations(step)); });
    model.print("model", "triangle");
    first = false;
  }
  Device<S>::State state = Device<S>::start();
  Counts device, observer, in_integers, starts;
  for (const StepRecord& r : file.records) {
    if ((r.inputs.flags & restart) != 0) {
      state = Device<S>::start();
    }
    const Inputs<S> in = inputs_of<S>(r.inputs);
    const Command<S> command = command_of<S>(r.inputs);
    const S dt_s(r.inputs.dt_s);
    const bool observed = state.observing;
    Device<S>::State copy = state;
    const std::uint64_t observe = operations([&] { Device<S>::observe(prepared, copy, in, dt_s); });
    const std::uint64_t whole =
        operations([&] { Device<S>::step(prepared, state, in, command, dt_s); });
    if (!observed) {
      starts.add(whole);
      continue;
    }
    device.add(whole);
    observer.add(observe);
    if (device.steps + starts.steps <= steps_in_integers) {
      in_integers.add(observe);
    }
  }
  const std::string name = std::filesystem::path(path).filename();
  device.print("device", name);
  observer.print("observer", name);
  in_integers.print("fixed_observer", name);
  starts.print("start", name);
  return true;
}

}  // namespace
}  // namespace smaservo::mcu

int main(int argc, char** argv) {
  for (int i = 1; i < argc; ++i) {
    if (!smaservo::mcu::count_file(argv[i])) {
      std::fprintf(stderr, "%s: is no step file\n", argv[i]);
      return 1;
    }
  }
  return argc > 1 ? 0 : 2;
}
