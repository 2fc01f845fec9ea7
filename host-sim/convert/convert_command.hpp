#pragma once

#include "host-sim/options.hpp"

namespace smaservo::convert {
void add_convert_command(CLI::App& app);
}  // namespace smaservo::convert
