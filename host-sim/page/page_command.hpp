#pragma once

#include "host-sim/options.hpp"

namespace smaservo::page {
void add_page_command(CLI::App& app);
}  // namespace smaservo::page
