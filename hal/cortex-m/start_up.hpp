#pragma once
// The start-up code between reset and the application, and a measurement of the stack's use.

#include <cstddef>

namespace smaservo::cortex_m {

/// The greatest number of bytes of the stack in use since reset or repaint_stack().
std::size_t stack_bytes();
/// Restarts the measurement of stack_bytes() from the caller's depth.
void repaint_stack();

}  // namespace smaservo::cortex_m

/// The program that runs after reset; its result is the exit code. It replaces main(), which C++
/// functions must not call.
int application();

/// Called in each SysTick interrupt; a program that uses the timer defines it.
extern "C" void sys_tick_interrupt();
