#pragma once
// What happens between reset and the application, and how deep the stack has become since.

#include <cstddef>

namespace smaservo::cortex_m {

/// Of the stack since reset, or since repaint_stack(), all of it included.
std::size_t stack_bytes();
/// Forgets what was used below the caller.
void repaint_stack();

}  // namespace smaservo::cortex_m

/// What runs after reset; its result is the program's. In place of main(), which C++ does not let
/// another function call.
int application();

/// Called in each SysTick interrupt; a program that uses it has its own.
extern "C" void sys_tick_interrupt();
