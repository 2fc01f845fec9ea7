#include "firmware/text/device_log.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <optional>

#include "firmware/text/device_names.hpp"
#include "firmware/text/settings_text.hpp"
#include "model/files/error.hpp"

namespace smaservo::text {
namespace {

constexpr std::size_t no_column = std::numeric_limits<std::size_t>::max();

std::string all_modes() {
  std::string names;
  for (std::uint8_t i = 0; i < mode_count; ++i) {
    names += fmt::format("{}{}", i == 0 ? "" : ", ", mode_name(static_cast<Mode>(i)));
  }
  return names;
}

}  // namespace

void split_fields(std::string_view row, std::vector<std::string_view>& fields) {
  fields.clear();
  for (;;) {
    const std::size_t comma = row.find(',');
    fields.push_back(row.substr(0, comma));
    if (comma == std::string_view::npos) {
      return;
    }
    row.remove_prefix(comma + 1);
  }
}

DeviceLog::DeviceLog(const std::string& trace, const std::vector<std::string>& names)
    : trace_(trace) {
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const auto found = std::ranges::find(names, columns.at(i));
    positions_.at(i) =
        found == names.end() ? no_column : static_cast<std::size_t>(found - names.begin());
  }
  for (const Which which : {mode, setpoint, arm}) {
    if (positions_.at(which) == no_column) {
      throw files::UserError(fmt::format(
          "{}: has no column {}; a device is replayed from command_mode, command_setpoint and "
          "command_arm, as simulate writes them",
          trace, columns.at(which)));
    }
  }
}

Heard<double> DeviceLog::heard(const std::vector<std::string_view>& fields, double time_s) const {
  return {command(fields, time_s), external(fields, time_s), late(fields, time_s)};
}

Command<double> DeviceLog::command(const std::vector<std::string_view>& fields,
                                   double time_s) const {
  const auto number = [&](Which which, double otherwise) {
    return positions_.at(which) == no_column
               ? otherwise
               : parse(fields.at(positions_.at(which)), which, time_s);
  };
  Command<double> command;
  const std::string_view name = fields.at(positions_.at(mode));
  const std::optional<Mode> known = mode_of(name);
  if (!known) {
    fail(mode, name, fmt::format("is no mode; the modes are: {}", all_modes()), time_s);
  }
  command.mode = *known;
  command.setpoint = number(setpoint, 0);
  command.fresh = number(fresh, 1) != 0;
  command.arm = number(arm, 0) != 0;
  command.clear_faults = number(clear, 0) != 0;
  command.scale = {number(proportional, 1), number(integral, 1), number(derivative, 1)};
  return command;
}

FaultSet DeviceLog::external(const std::vector<std::string_view>& fields, double time_s) const {
  if (positions_.at(faults) == no_column) {
    return {};
  }
  const std::string_view names = fields.at(positions_.at(faults));
  const std::optional<FaultSet> known = named_faults(names);
  if (!known) {
    fail(faults, names, "has a fault that firmware/reference/FAULTS.md does not know", time_s);
  }
  return *known;
}

bool DeviceLog::late(const std::vector<std::string_view>& fields, double time_s) const {
  return positions_.at(deadline) != no_column &&
         parse(fields.at(positions_.at(deadline)), deadline, time_s) != 0;
}

bool DeviceLog::change(const std::vector<std::string_view>& fields, double time_s,
                       Settings<double>& settings) const {
  if (positions_.at(changes) == no_column || fields.at(positions_.at(changes)).empty()) {
    return false;
  }
  const std::string_view text = fields.at(positions_.at(changes));
  const std::string problem = apply_changes(text, settings);
  if (!problem.empty()) {
    fail(changes, text, problem, time_s);
  }
  return true;
}

void DeviceLog::fail(Which which, std::string_view field, std::string_view what,
                     double time_s) const {
  throw files::UserError(
      fmt::format("{}: at {} s: {} = '{}' {}", trace_, time_s, columns.at(which), field, what));
}

double DeviceLog::parse(std::string_view field, Which which, double time_s) const {
  double value = 0;
  const char* const begin = field.data();
  const char* const stop = begin + field.size();
  const auto [at, error] = std::from_chars(begin, stop, value);
  if (error != std::errc{} || at != stop || !std::isfinite(value)) {
    fail(which, field, "is not a finite number", time_s);
  }
  return value;
}

}  // namespace smaservo::text
