#pragma once
// The processor's registers that are used here, as in the Armv7-M and Armv8-M reference manuals.

#include <cstdint>

namespace smaservo::cortex_m {

template <class T>
inline T& at(std::uintptr_t address) {
  return *reinterpret_cast<T*>(address);
}

/// Period of the processor's clock, from the toolchain file.
inline constexpr std::uint32_t clock_ns = SMASERVO_MCU_CLOCK_NS;

/// A timer that counts down with the processor's clock.
struct SysTick {
  static constexpr std::uint32_t enable = 1U << 0U;
  static constexpr std::uint32_t interrupt = 1U << 1U;
  static constexpr std::uint32_t processor_clock = 1U << 2U;
  static constexpr std::uint32_t longest = 0xFFFFFF;

  volatile std::uint32_t control;
  volatile std::uint32_t reload;
  volatile std::uint32_t value;
  volatile std::uint32_t calibration;
};
inline SysTick& sys_tick() {
  return at<SysTick>(0xE000E010);
}

/// Coprocessor access control: which privilege levels may use the floating-point unit.
inline volatile std::uint32_t& cpacr() {
  return at<volatile std::uint32_t>(0xE000ED88);
}

inline void data_barrier() {
  asm volatile("dsb" ::: "memory");
}
inline void instruction_barrier() {
  asm volatile("isb" ::: "memory");
}
inline void wait_for_interrupt() {
  asm volatile("wfi" ::: "memory");
}

}  // namespace smaservo::cortex_m
