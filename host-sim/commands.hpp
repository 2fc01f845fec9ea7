#pragma once
// The sub-commands of host-sim: each function adds one to the program, which runs it when the
// command line is parsed. Only commands.cpp and *_command.cpp include this header. They are
// compiled as one source, since CLI11 takes five seconds to compile.

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

namespace smaservo::convert {
void add_convert_command(CLI::App& app);
}  // namespace smaservo::convert

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

namespace smaservo::page {
void add_page_command(CLI::App& app);
}  // namespace smaservo::page

namespace smaservo::plan {
void add_calibrate_plan_command(CLI::App& app);
}  // namespace smaservo::plan

namespace smaservo::replay {
void add_replay_command(CLI::App& app);
void add_replay_device_command(CLI::App& app);
}  // namespace smaservo::replay

namespace smaservo::simulate {
void add_simulate_command(CLI::App& app);
}  // namespace smaservo::simulate

namespace smaservo::tune {
void add_tune_command(CLI::App& app);
}  // namespace smaservo::tune

namespace smaservo {

/// Checks that an option's value, if given, is in this range. Throws UserError.
void require(const char* option, const std::optional<double>& value, double low, double high);

/// Throws UserError if both names denote the same file. A device, "-" and an empty name are not
/// files.
void refuse_to_overwrite(const std::string& file, const std::string& output);

}  // namespace smaservo
