#pragma once
// The sub-commands of host-sim; each adds itself to the program and runs when it is parsed. For
// sources that are named so, *_command.cpp, which are compiled as one: CLI11 takes five seconds in
// each.

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

#include "firmware/text/settings_file.hpp"

namespace smaservo::can {
void add_can_command(CLI::App& app);
}  // namespace smaservo::can

namespace smaservo::compare {
void add_compare_command(CLI::App& app);
}  // namespace smaservo::compare

namespace smaservo::describe {
void add_describe_command(CLI::App& app);
void add_explain_command(CLI::App& app);
void add_wires_command(CLI::App& app);
}  // namespace smaservo::describe

namespace smaservo::evaluate {
void add_evaluate_command(CLI::App& app);
}  // namespace smaservo::evaluate

namespace smaservo::figures {
void add_figures_command(CLI::App& app);
}  // namespace smaservo::figures

namespace smaservo::identify {
void add_identify_command(CLI::App& app);
}  // namespace smaservo::identify

namespace smaservo::plan {
void add_calibrate_plan_command(CLI::App& app);
}  // namespace smaservo::plan

namespace smaservo::replay {
void add_replay_command(CLI::App& app);
}  // namespace smaservo::replay

namespace smaservo::simulate {
void add_simulate_command(CLI::App& app);
}  // namespace smaservo::simulate

namespace smaservo::tune {
void add_tune_command(CLI::App& app);
}  // namespace smaservo::tune

namespace smaservo {

/// A number that an option may give, by its range. Throws UserError.
void require(const char* option, const std::optional<double>& value, double low, double high);

/// Throws UserError when both are names of one file. Devices, "-" and no name at all are none.
void refuse_to_overwrite(const std::string& file, const std::string& output);

}  // namespace smaservo
