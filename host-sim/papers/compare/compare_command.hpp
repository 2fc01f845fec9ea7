#pragma once

#include "host-sim/options.hpp"

namespace smaservo::compare {
void add_compare_command(CLI::App& app);
}  // namespace smaservo::compare
