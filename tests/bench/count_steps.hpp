#pragma once
// What count_steps runs, by name.

#include <cstddef>
#include <functional>
#include <map>
#include <string>

namespace smaservo::benchmarks {

/// A step of any kind.
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

/// Calls the step so many times; its name is what callgrind looks for, so it has no template
/// arguments in it and is never inlined.
extern "C" void counted_steps(const AnyStep& step, std::size_t times);

inline constexpr std::size_t periods = 2;

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

/// Adds a kind of step under its name.
inline auto adding(Runs& runs, const std::string& scalar) {
  return [&runs, scalar](const std::string& name, auto make) {
    runs[name + "/" + scalar] = [make](const Part& part) {
      auto step = make();
      return run(step, part);
    };
  };
}

void add_device_runs(Runs& runs);
void add_paper_runs(Runs& runs);
void add_wire_runs(Runs& runs);

}  // namespace smaservo::benchmarks
