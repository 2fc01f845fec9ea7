#pragma once

#include "host-sim/options.hpp"

namespace smaservo::plan {
void add_calibrate_plan_command(CLI::App& app);
}  // namespace smaservo::plan
