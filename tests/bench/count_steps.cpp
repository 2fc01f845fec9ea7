// Runs steps of one kind inside one function, for callgrind to count its instructions:
//   valgrind --tool=callgrind --toggle-collect=counted_steps count_steps KIND/SCALAR [PART]
// Without arguments it lists the kinds.

#include "tests/bench/count_steps.hpp"

#include <cstdio>
#include <string_view>

#include "tests/bench/steps.hpp"

extern "C" [[gnu::noinline]] void smaservo::benchmarks::counted_steps(const AnyStep& step,
                                                                      std::size_t times) {
  step.repeat(step.object, times);
}

int main(int argc, char** argv) {
  using namespace smaservo::benchmarks;
  Runs runs;
  for_each_step<float>(adding(runs, "float"));
  for_each_step<double>(adding(runs, "double"));
  add_device_runs(runs);
  add_paper_runs(runs);
  add_wire_runs(runs);
  if (argc == 1) {
    for (const auto& [name, _] : runs) {
      std::puts(name.c_str());
    }
    return 0;
  }
  const auto chosen = runs.find(std::string_view(argv[1]));
  const std::string_view part = argc > 2 ? argv[2] : "all";
  if (chosen == runs.end() || (part != "all" && part != "heating" && part != "cooling")) {
    std::fputs("usage: count_steps [KIND/SCALAR [all|heating|cooling]]\n", stderr);
    return 2;
  }
  const std::size_t steps = chosen->second({part != "cooling", part != "heating"});
  std::printf("%zu\n", steps);
  return 0;
}
