#pragma once

#include <string>

namespace smaservo::daemon {

/// From now on the calling thread may make only the system calls that a loop needs: sleep, clocks,
/// reads, writes and ioctls of open descriptors, and its end. Any other call ends the program with
/// SIGSYS. Meant for tests (`smaservod --sandbox`); it cannot be undone. Returns the error; empty
/// if there is none.
std::string allow_loop_calls_only();

}  // namespace smaservo::daemon
