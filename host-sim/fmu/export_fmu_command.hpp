#pragma once

#include "host-sim/options.hpp"

namespace smaservo::fmu {
void add_export_fmu_command(CLI::App& app);
}  // namespace smaservo::fmu
