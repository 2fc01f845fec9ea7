#pragma once

#include <CLI/CLI.hpp>

namespace smaservo::record {
void add_record_command(CLI::App& app);
}  // namespace smaservo::record
