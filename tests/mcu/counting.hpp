#pragma once
// Counts instructions in QEMU with -icount shift=10: an instruction takes 1024 ns.

#include <algorithm>
#include <array>
#include <cstdint>

#include "hal/cortex-m/registers.hpp"
#include "tests/mcu/printing.hpp"

namespace smaservo::mcu {

inline void start_counter() {
  using cortex_m::sys_tick;
  sys_tick().reload = cortex_m::SysTick::longest;
  sys_tick().value = 0;
  sys_tick().control = cortex_m::SysTick::enable | cortex_m::SysTick::processor_clock;
}

/// At most 655 000.
template <class F>
[[gnu::noinline]] std::uint32_t instructions(F f) {
  using cortex_m::sys_tick;
  sys_tick().value = 0;
  cortex_m::data_barrier();
  const std::uint32_t before = sys_tick().value;
  f();
  asm volatile("" ::: "memory");
  const std::uint32_t ticks = (before - sys_tick().value) & cortex_m::SysTick::longest;
  return static_cast<std::uint32_t>(std::uint64_t{ticks} * cortex_m::clock_ns / 1024);
}

inline std::uint32_t empty() {
  static const std::uint32_t cost = instructions([] {});
  return cost;
}

/// By itself: no function that needs literals can hold so much.
[[gnu::noinline]] inline void thousand_instructions() {
  asm volatile(".rept 1000\n nop\n .endr");
}

/// Whether a thousand instructions, and the call, are that: the clock is that of the machine.
inline bool counts_well() {
  const std::uint32_t counted = instructions(thousand_instructions) - empty();
  const bool well = 1000 <= counted && counted <= 1005;
  if (!well) {
    say("1000 instructions are counted as ", counted, "\n");
  }
  return well;
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

/// Of the program's arguments; whether there are some and `count` takes all of them.
template <class F>
bool for_each_file(F count) {
  static std::array<char, 4096> line{};
  std::string_view names = semihosting::arguments(line);
  bool all = !names.empty();
  while (!names.empty()) {
    const std::size_t blank = std::min(names.find(' '), names.size());
    std::array<char, 256> name{};
    names.copy(name.data(), std::min(blank, name.size() - 1));
    all = count(std::string_view(name.data(), blank)) && all;
    names.remove_prefix(std::min(blank + 1, names.size()));
  }
  return all;
}

/// The exit code of a program that counts its arguments' files.
template <class F>
int count_files(F count) {
  start_counter();
  return counts_well() && for_each_file(count) ? 0 : 1;
}

}  // namespace smaservo::mcu
