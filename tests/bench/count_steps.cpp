// Runs steps of one kind inside one function, for callgrind to count its instructions:
//   valgrind --tool=callgrind --toggle-collect=counted_steps count_steps KIND/SCALAR [PART]
// Without arguments it lists the kinds.

#include <cstdio>
#include <functional>
#include <map>
#include <string>
#include <string_view>

#include "tests/bench/steps.hpp"

namespace {

/// Calls `step` so many times; its name is what callgrind looks for, so it has no template
/// arguments in it and is never inlined.
struct AnyStep {
  void* object;
  void (*repeat)(void* object, std::size_t times);
};

template <class Step>
void repeat(void* object, std::size_t times) {
  Step& step = *static_cast<Step*>(object);
  for (std::size_t i = 0; i < times; ++i) {
    step();
    asm volatile("" : : "r"(object) : "memory");
  }
}

}  // namespace

extern "C" [[gnu::noinline]] void counted_steps(const AnyStep& step, std::size_t times) {
  step.repeat(step.object, times);
}

namespace {

constexpr std::size_t periods = 2;

/// Which part of each period is counted.
struct Part {
  bool first, second;
};

template <class Step>
std::size_t run(Step& step, const Part& part) {
  const AnyStep any{&step, &repeat<Step>};
  const std::size_t half = step.period() / 2;
  any.repeat(any.object, step.period());  // beyond the start's transient
  std::size_t counted = 0;
  for (std::size_t i = 0; i < 2 * periods; ++i) {
    const bool counts = i % 2 == 0 ? part.first : part.second;
    if (counts) {
      counted_steps(any, half);
      counted += half;
    } else {
      any.repeat(any.object, half);
    }
  }
  return counted;
}

using Runs = std::map<std::string, std::function<std::size_t(const Part&)>, std::less<>>;

template <class S>
void add_runs(Runs& runs, const std::string& scalar) {
  smaservo::bench::for_each_step<S>([&](const std::string& name, auto make) {
    runs[name + "/" + scalar] = [make](const Part& part) {
      auto step = make();
      return run(step, part);
    };
  });
}

}  // namespace

int main(int argc, char** argv) {
  Runs runs;
  add_runs<float>(runs, "float");
  add_runs<double>(runs, "double");
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
