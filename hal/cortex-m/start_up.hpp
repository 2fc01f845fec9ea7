#pragma once
// The start between reset and the application, and the use of the stack.

#include <cstddef>

namespace smaservo::cortex_m {

/// The most bytes of the stack that were in use at once since reset or repaint_stack().
std::size_t stack_bytes();
/// Begins the measurement of stack_bytes() anew from the caller's depth.
void repaint_stack();

}  // namespace smaservo::cortex_m

/// The program that runs after reset; its result is the exit code. It stands in place of main(),
/// which no C++ function may call.
int application();

/// Called in each SysTick interrupt; a program that uses the timer defines it.
extern "C" void sys_tick_interrupt();
