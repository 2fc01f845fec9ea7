#pragma once

#include <string>

namespace smaservo::daemon {

/// From now on the calling thread may make the system calls of a loop only: its sleep, its clocks,
/// reads, writes and ioctls of descriptors that are open, its end. Any other one ends the program
/// with SIGSYS. For proofs (`smaservod --sandbox`); there is no way back. Empty, or
/// why the kernel refuses.
std::string allow_loop_calls_only();

}  // namespace smaservo::daemon
