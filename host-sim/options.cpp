#include "host-sim/options.hpp"

#include <filesystem>
#include <fmt/format.h>

#include "model/files/error.hpp"

namespace smaservo {

void add_units_option(CLI::App& command, Units& units, const std::string& what) {
  command
      .add_option_function<std::string>(
          "--units",
          [&units](const std::string& name) { units = name == "si" ? Units::si : Units::bench; },
          what + ": bench (degC, MPa, mA, mW, um, mm/s, %) or si")
      ->check(CLI::IsMember({"bench", "si"}))
      ->default_str(units == Units::bench ? "bench" : "si");
}

void add_report_options(CLI::App& command, std::string& report, Units& units,
                        const std::string& help) {
  command.add_option("--report", report, help);
  add_units_option(command, units, "units of the report's panels");
}

void require(const char* option, const std::optional<double>& value, double low, double high) {
  if (value && !(*value >= low && *value <= high)) {
    throw files::UserError(
        fmt::format("{} {}: must be between {} and {}", option, *value, low, high));
  }
}

void refuse_to_overwrite(const std::string& file, const std::string& output) {
  std::error_code missing;
  const bool plain = !file.empty() && !output.empty() && file != "-" && output != "-";
  if (plain && std::filesystem::exists(output, missing) &&
      !std::filesystem::is_regular_file(output, missing)) {
    return;
  }
  if (plain && (file == output || std::filesystem::equivalent(file, output, missing))) {
    throw files::UserError(fmt::format("{}: is the same file as {}", output, file));
  }
}

}  // namespace smaservo
