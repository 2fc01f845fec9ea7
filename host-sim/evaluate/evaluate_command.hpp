#pragma once

#include "host-sim/options.hpp"

namespace smaservo::evaluate {
void add_evaluate_command(CLI::App& app);
}  // namespace smaservo::evaluate
