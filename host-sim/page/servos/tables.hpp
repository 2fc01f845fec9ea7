#pragma once
// The firmware's own tables, and requests of clients, as JSON.

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "firmware/parameters/parameters.hpp"
#include "host-sim/can/bus/recording.hpp"
#include "host-sim/page/servos/history.hpp"
#include "host-sim/page/source.hpp"

namespace smaservo::page {

/// The shortest number that reads back to the same float; null where it is not finite.
nlohmann::json json_number(float value);
/// One line; bytes that are no UTF-8 are replaced.
std::string json_text(const nlohmann::json& value);

/// The answer of `describe`.
nlohmann::json described();

/// The text of a sample as smaservo.Live has it.
std::string live_text(const Sample& sample);
nlohmann::json history_message(const HistoryRows& rows, std::int64_t wall_ns_at_0);
nlohmann::json recording_message(const can::Recording& recording);
/// Throws UserError.
can::Recording recording_of(const nlohmann::json& message);

/// A parameter's value as JSON: a number, true or false, the name of a choice.
std::string parameter_json(const Parameter<double>& row, Value value);
/// The text of a JSON value as text::value_bytes() takes it. Throws UserError where its type is not
/// the parameter's.
std::string parameter_text(const Parameter<double>& row, const nlohmann::json& value);

/// "node3.strain.proportional_W"
struct ParameterName {
  unsigned node;
  std::size_t row;
};
/// Throws UserError, which says what is wrong.
ParameterName parameter_of(const std::string& name);
/// The row of a parameter by its path. Throws UserError with similar names.
std::size_t parameter_row(const std::string& path);

/// A member of a request. Each throws UserError, which names the member and what it must be.
nlohmann::json parsed_request(const std::string& text);
unsigned node_in(const nlohmann::json& request);
double number_in(const nlohmann::json& request, const char* name, double low, double high);
std::string text_in(const nlohmann::json& request, const char* name);

/// RFC 4648.
std::string base64(const std::string& bytes);

/// JSON schemas of the channels.
std::string bridge_schema();
std::string live_schema();
std::string state_schema();

}  // namespace smaservo::page
