#pragma once

#include "host-sim/options.hpp"

namespace smaservo::simulate {
void add_simulate_command(CLI::App& app);
}  // namespace smaservo::simulate
