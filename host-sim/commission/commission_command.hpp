#pragma once

#include "host-sim/options.hpp"

namespace smaservo::commission {

/// Adds the command `commission`.
void add_commission_command(CLI::App& app);

}  // namespace smaservo::commission
