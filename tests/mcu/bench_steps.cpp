// Counts the instructions of steps on step files, in QEMU with -icount shift=10: an instruction
// takes 1024 ns, 25.6 ticks of the board's 25 MHz. Prints lines of a name and numbers.

#include <algorithm>
#include <cstdint>
#include <optional>

#include "hal/cortex-m/registers.hpp"
#include "hal/cortex-m/start_up.hpp"
#include "tests/mcu/printing.hpp"
#include "tests/mcu/step_reader.hpp"

namespace smaservo::mcu {
namespace {

using S = float;
using cortex_m::sys_tick;

void start_counter() {
  sys_tick().reload = cortex_m::SysTick::longest;
  sys_tick().value = 0;
  sys_tick().control = cortex_m::SysTick::enable | cortex_m::SysTick::processor_clock;
}

/// At most 655 000.
template <class F>
[[gnu::noinline]] std::uint32_t instructions(F f) {
  sys_tick().value = 0;
  cortex_m::data_barrier();
  const std::uint32_t before = sys_tick().value;
  f();
  asm volatile("" ::: "memory");
  const std::uint32_t ticks = (before - sys_tick().value) & cortex_m::SysTick::longest;
  return static_cast<std::uint32_t>(std::uint64_t{ticks} * 10 / 256);
}

std::uint32_t empty() {
  static const std::uint32_t cost = instructions([] {});
  return cost;
}

struct Counts {
  std::uint64_t sum = 0;
  std::uint32_t steps = 0, worst = 0, worst_at = 0;

  void add(std::uint32_t count) {
    const std::uint32_t own = count - empty();
    sum += own;
    worst_at = worst < own ? steps : worst_at;
    worst = std::max(worst, own);
    ++steps;
  }
  void print(std::string_view name, std::string_view file) const {
    say(name, " ", file, " ", steps, " ", steps == 0 ? 0 : sum / steps, " ", worst, " ", worst_at,
        "\n");
  }
};

/// Out of line, as a board's loop would call it.
[[gnu::noinline]] void device_step(const Prepared<S>& p, Device<S>::State& s, const Inputs<S>& in,
                                   const Command<S>& command, const S& dt_s) {
  Device<S>::step(p, s, in, command, dt_s);
}
[[gnu::noinline]] void observer_step(const Prepared<S>& p, Device<S>::State& s, const Inputs<S>& in,
                                     const S& dt_s) {
  Device<S>::observe(p, s, in, dt_s);
}
[[gnu::noinline]] void model_step(const ThreePhase<S>::Params& p, const ThreePhase<S>::Cut& cut,
                                  ThreePhase<S>::State& s, const S& temperature_K) {
  ThreePhase<S>::advance(p, cut, s, temperature_K);
}

/// 20 to 110 °C and back under 150 MPa, twice, as tests/bench/steps.hpp has it.
void count_model_steps(const Prepared<S>& prepared) {
  constexpr int half = 1800;
  const ThreePhase<S>::Params& p = prepared.observer.model.kinetics;
  const auto cut = ThreePhase<S>::cut(p, S(150e6));
  auto state = ThreePhase<S>::rest(p, {S(293.15), S(150e6)});
  Counts counts;
  for (int i = 1; i <= 4 * half; ++i) {
    const int at = i % (2 * half);
    const S temperature_K = S(293.15) + S(0.05) * static_cast<S>(at <= half ? at : 2 * half - at);
    const std::uint32_t count = instructions([&] { model_step(p, cut, state, temperature_K); });
    if (2 * half < i) {
      counts.add(count);
    }
  }
  counts.print("model", "triangle");
}

Prepared<S> prepared;  // static, as a firmware keeps it
Device<S>::State state, copy;

/// The stack that a step needs below its caller.
std::size_t step_stack(const StepInputs& r, const Inputs<S>& in, const Command<S>& command) {
  copy = state;
  cortex_m::repaint_stack();
  device_step(prepared, copy, in, command, r.dt_s);
  return cortex_m::stack_bytes();
}

bool count_file(std::string_view name) {
  static std::optional<StepReader> opened;
  StepReader& reader = opened.emplace(name);
  const auto settings = reader.settings<S>();
  if (!settings) {
    say("no settings in ", name, "\n");
    return false;
  }
  prepared = prepare(*settings);
  static bool first = true;
  if (first) {
    count_model_steps(prepared);
    first = false;
  }
  state = Device<S>::start();
  Counts device, observer, starts;
  std::size_t stack = 0;
  while (const StepRecord* r = reader.next()) {
    if ((r->inputs.flags & restart) != 0) {
      state = Device<S>::start();
    }
    const Inputs<S> in = inputs_of<S>(r->inputs);
    const Command<S> command = command_of<S>(r->inputs);
    if (device.steps % 64 == 0) {
      stack = std::max(stack, step_stack(r->inputs, in, command));
    }
    copy = state;
    const std::uint32_t observe =
        instructions([&] { observer_step(prepared, copy, in, r->inputs.dt_s); });
    const bool observed = state.observing;
    const std::uint32_t whole =
        instructions([&] { device_step(prepared, state, in, command, r->inputs.dt_s); });
    if (observed) {
      observer.add(observe);
      device.add(whole);
    } else {
      starts.add(whole);
    }
  }
  const std::string_view file = name.substr(name.rfind('/') + 1);
  device.print("device", file);
  observer.print("observer", file);
  starts.print("start", file);
  say("stack ", file, " ", stack, "\n");
  return true;
}

bool count_all(std::string_view names) {
  bool all = !names.empty();
  while (!names.empty()) {
    const std::size_t blank = std::min(names.find(' '), names.size());
    std::array<char, 256> name{};
    names.copy(name.data(), std::min(blank, name.size() - 1));
    all = count_file(std::string_view(name.data(), blank)) && all;
    names.remove_prefix(std::min(blank + 1, names.size()));
  }
  return all;
}

}  // namespace
}  // namespace smaservo::mcu

int application() {
  using namespace smaservo;
  mcu::start_counter();
  static std::array<char, 4096> line{};
  return mcu::count_all(semihosting::arguments(line)) ? 0 : 1;
}
