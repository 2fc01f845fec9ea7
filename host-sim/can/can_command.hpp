#pragma once

#include "host-sim/options.hpp"

namespace smaservo::can {
void add_can_command(CLI::App& app);
}  // namespace smaservo::can
