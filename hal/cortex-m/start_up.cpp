#include "hal/cortex-m/start_up.hpp"

#include <algorithm>
#include <cstdint>

#include "hal/cortex-m/registers.hpp"
#include "hal/cortex-m/semihosting.hpp"

// Symbols of the linker script.
extern "C" {
extern std::uint32_t data_image[], data_begin[], data_end[], bss_begin[], bss_end[], stack_top[];
using Initialiser = void (*)();
extern Initialiser init_begin[], init_end[];
[[noreturn]] void reset();
}

namespace smaservo::cortex_m {
namespace {

constexpr std::uint32_t paint = 0x5AFE57AC;

std::uint32_t* stack_pointer() {
  std::uint32_t* now = nullptr;
  asm volatile("mov %0, sp" : "=r"(now));
  return now;
}

void enable_floating_point() {
#ifdef __ARM_FP
  cpacr() = cpacr() | 0xFU << 20U;
  data_barrier();
  instruction_barrier();
#endif
}

}  // namespace

/// Fills the stack below its own frame with a pattern. Not inlined, so that no variable of the
/// caller lies there.
[[gnu::noinline]] void repaint_stack() {
  volatile std::uint32_t* const top = stack_pointer() - 16;
  for (volatile std::uint32_t* at = bss_end; at < top; ++at) {
    *at = paint;
  }
}

std::size_t stack_bytes() {
  const std::uint32_t* const used =
      std::find_if(bss_end, stack_top, [](std::uint32_t word) { return word != paint; });
  return static_cast<std::size_t>(stack_top - used) * sizeof(std::uint32_t);
}

}  // namespace smaservo::cortex_m

extern "C" {

void reset() {
  using namespace smaservo;
  cortex_m::enable_floating_point();
  std::copy(data_image, data_image + (data_end - data_begin), data_begin);
  std::fill(bss_begin, bss_end, 0U);
  cortex_m::repaint_stack();
  std::for_each(init_begin, init_end, [](Initialiser initialise) { initialise(); });
  semihosting::leave(application());
}

// A real board switches its drive off here; here the lease does so, as it is no longer renewed.
[[noreturn]] void fault() {
  smaservo::semihosting::print("processor fault\n");
  smaservo::semihosting::leave(125);
}

// The C library calls these functions when it gives up, or to destroy static objects.
[[noreturn]] void abort() {
  fault();
}
[[noreturn]] void __cxa_pure_virtual() {
  fault();
}
// The C library's own function would add 100 bytes of state for files and locales.
int* __errno() {
  static int number = 0;
  return &number;
}
int __aeabi_atexit(void* /*object*/, void (* /*destroy*/)(void*), void* /*module*/) {
  return 0;
}
void* __dso_handle = nullptr;

[[gnu::weak]] void sys_tick_interrupt() {}

using Vector = void (*)();
[[gnu::section(".vectors"), gnu::used]] const Vector vectors[16] = {
    reinterpret_cast<Vector>(stack_top),
    reset,
    fault,
    fault,
    fault,
    fault,
    fault,
    fault,
    nullptr,
    nullptr,
    nullptr,
    fault,
    fault,
    nullptr,
    fault,
    sys_tick_interrupt};

}  // extern "C"
