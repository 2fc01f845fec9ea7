#pragma once

#include "host-sim/options.hpp"

namespace smaservo::campaign {

void add_campaign_command(CLI::App& app);

}  // namespace smaservo::campaign
