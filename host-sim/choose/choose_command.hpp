#pragma once

#include "host-sim/options.hpp"

namespace smaservo::choose {

void add_choose_command(CLI::App& app);

}  // namespace smaservo::choose
