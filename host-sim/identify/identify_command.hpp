#pragma once

#include "host-sim/options.hpp"

namespace smaservo::identify {
void add_identify_command(CLI::App& app);
}  // namespace smaservo::identify
