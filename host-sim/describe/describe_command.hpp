#pragma once

#include "host-sim/options.hpp"

namespace smaservo::describe {
void add_describe_command(CLI::App& app);
void add_explain_command(CLI::App& app);
void add_wires_command(CLI::App& app);
}  // namespace smaservo::describe
