#pragma once
// The list of all commands of host-sim.

namespace smaservo::commands {

/// Runs the command of the command line; returns the exit code. Throws the exceptions of the
/// command.
int run_host_sim(int argc, char** argv);

}  // namespace smaservo::commands
