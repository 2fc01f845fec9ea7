#pragma once
// The firmware's own tables, and the readings of a servo, as JSON.

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "firmware/parameters/parameters.hpp"
#include "host-sim/can/bus/recording.hpp"
#include "host-sim/can/settings.hpp"
#include "host-sim/page/servos/history.hpp"

namespace smaservo::page {

/// The shortest number that reads back to the same float; null if it is not finite.
nlohmann::json json_number(float value);
/// The value on one line; bytes that are not UTF-8 are replaced.
std::string json_text(const nlohmann::json& value);

/// The answer to the service `describe`.
nlohmann::json described();

/// The text of a sample for smaservo.Live.
std::string live_text(const Sample& sample);
/// The bytes of a sample as live_definition() describes them; NaN for missing signals.
std::string live_bytes(const Sample& sample);
nlohmann::json history_message(const HistoryRows& rows, std::int64_t wall_ns_at_0);
nlohmann::json recording_message(const can::Recording& recording);

/// A parameter's value as JSON: a number, true or false, the name of a choice.
std::string parameter_json(const Parameter<double>& row, Value value);
/// The text of a JSON value for text::value_bytes(). Throws UserError if its type is not the
/// parameter's.
std::string parameter_text(const Parameter<double>& row, const nlohmann::json& value);

/// One object {name, file, node} for each.
nlohmann::json difference_messages(const std::vector<can::Difference>& all);

/// A parameter of a node, such as "node3.strain.proportional_W".
struct ParameterName {
  unsigned node;
  std::size_t row;
};
/// Throws UserError with the reason if the name is wrong.
ParameterName parameter_of(const std::string& name);
/// The row of a parameter by its path. Throws UserError, which names similar parameters.
std::size_t parameter_row(const std::string& path);

}  // namespace smaservo::page
