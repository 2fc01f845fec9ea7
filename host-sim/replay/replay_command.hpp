#pragma once

#include "host-sim/options.hpp"

namespace smaservo::replay {
void add_replay_command(CLI::App& app);
void add_replay_device_command(CLI::App& app);
}  // namespace smaservo::replay
