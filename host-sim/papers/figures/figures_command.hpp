#pragma once

#include "host-sim/options.hpp"

namespace smaservo::figures {
void add_figures_command(CLI::App& app);
}  // namespace smaservo::figures
