#pragma once
// The log of a device: what its trace has beside the readings, so that it can be replayed.

#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "firmware/device/cycle.hpp"
#include "firmware/settings.hpp"

namespace smaservo::text {

/// The texts of a row's fields.
void split_fields(std::string_view row, std::vector<std::string_view>& fields);

/// Commands, and what else went into the steps, from a trace's columns. All throw UserError with
/// the trace, the time and the field.
class DeviceLog {
 public:
  /// The trace's name must outlive it. The names must have command_mode, command_setpoint and
  /// command_arm.
  DeviceLog(const std::string& trace, const std::vector<std::string>& names);

  /// All but the set-points that were superseded: a log has none of them.
  Heard<double> heard(const std::vector<std::string_view>& fields, double time_s) const;
  /// Changes the settings that are in force from this row on; false where nothing changes.
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
