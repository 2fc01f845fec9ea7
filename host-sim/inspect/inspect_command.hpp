#pragma once

#include "host-sim/options.hpp"

namespace smaservo::inspect {

void add_inspect_command(CLI::App& app);

}  // namespace smaservo::inspect
