#pragma once
// The sub-commands of host-sim; each adds itself to the program and runs when it is parsed.

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "model/wires/wire_file.hpp"

namespace smaservo {

void add_replay_command(CLI::App& app);
void add_simulate_command(CLI::App& app);
void add_wires_command(CLI::App& app);

/// The meaning of --set in all of them: "key=value" split. Throws UserError.
std::vector<Override> parse_settings(const std::vector<std::string>& texts);

}  // namespace smaservo
