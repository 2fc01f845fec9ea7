#pragma once

#include "host-sim/options.hpp"

namespace smaservo::tune {
void add_tune_command(CLI::App& app);
}  // namespace smaservo::tune
