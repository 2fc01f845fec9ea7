#pragma once
// The log of a device: the columns of its trace that a replay needs beside the readings.

#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "firmware/cycle.hpp"
#include "firmware/settings.hpp"

namespace smaservo::text {

/// Splits a row into the texts of its fields.
void split_fields(std::string_view row, std::vector<std::string_view>& fields);

/// Reads the commands, and the other inputs of the steps, from a trace's columns. All functions
/// throw UserError, which names trace, time and field.
class DeviceLog {
 public:
  /// `trace` is the trace's name and must outlive the log. `names` are the columns; command_mode,
  /// command_setpoint and command_arm must be among them.
  DeviceLog(const std::string& trace, const std::vector<std::string>& names);

  /// What the device heard in this row; superseded set-points are not in a log.
  Heard<double> heard(const std::vector<std::string_view>& fields, double time_s) const;
  /// Applies the row's changes of parameters to the settings; false where it has none.
  bool change(const std::vector<std::string_view>& fields, double time_s,
              Settings<double>& settings) const;

 private:
  enum Which : unsigned char {
    mode,
    setpoint,
    arm,
    fresh,
    clear,
    proportional,
    integral,
    derivative,
    deadline,
    faults,
    changes
  };
  static constexpr std::array<std::string_view, 11> columns{
      "command_mode",    "command_setpoint",     "command_arm",      "command_fresh",
      "command_clear",   "command_proportional", "command_integral", "command_derivative",
      "deadline_missed", "external_faults",      "parameter_changes"};

  Command<double> command(const std::vector<std::string_view>& fields, double time_s) const;
  FaultSet external(const std::vector<std::string_view>& fields, double time_s) const;
  bool late(const std::vector<std::string_view>& fields, double time_s) const;
  [[noreturn]] void fail(Which which, std::string_view field, std::string_view what,
                         double time_s) const;
  double parse(std::string_view field, Which which, double time_s) const;

  const std::string& trace_;
  std::array<std::size_t, columns.size()> positions_{};
};

}  // namespace smaservo::text
