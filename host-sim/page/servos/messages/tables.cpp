#include "host-sim/page/servos/messages/tables.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <fmt/format.h>
#include <limits>

#include "firmware/command.hpp"
#include "firmware/safety/faults/table.hpp"
#include "firmware/text/canopen/objects.hpp"
#include "firmware/text/device_names.hpp"
#include "firmware/text/fault_reference.hpp"
#include "firmware/text/settings_text.hpp"
#include "host-sim/page/servos/servo.hpp"
#include "model/files/error.hpp"
#include "model/files/message.hpp"

namespace smaservo::page {
namespace {

using files::UserError;
using nlohmann::json;

constexpr std::size_t limit_reason_signal = signal_index("limit_reasons");

json value_json(const Parameter<double>& row, Value value) {
  switch (row.type) {
    case ValueType::real:
      return json_number(value.real());
    case ValueType::boolean:
      return value.number() != 0;
    case ValueType::choice:
      return value.number() < row.choices.size() ? json(row.choices[value.number()]) : json();
    case ValueType::number:
      break;
  }
  return value.number();
}

/// The units in which a person may write the value, SI's own first: those that the tools take at
/// the end of the name.
json units_description(const Parameter<double>& row) {
  json units = json::array();
  for (const Unit& unit : row.kind) {
    units.push_back({{"unit", unit.suffix}, {"factor", unit.factor}, {"offset", unit.offset}});
  }
  return units;
}

json parameter_description(const Parameter<double>& row) {
  static constexpr const char* changes[] = {"live", "not enabled", "after reset"};
  static constexpr const char* types[] = {"number", "integer", "choice", "boolean"};
  const auto type = static_cast<std::size_t>(row.type == ValueType::real     ? 0
                                             : row.type == ValueType::number ? 1
                                             : row.type == ValueType::choice ? 2
                                                                             : 3);
  json described{{"name", row.path.text()},
                 {"type", types[type]},
                 {"unit", row.kind.empty() ? "" : row.kind.front().suffix},
                 {"default", row.has_default() ? value_json(row, row.standard) : json()},
                 {"change", changes[static_cast<std::size_t>(row.change)]},
                 {"level", level_names[static_cast<std::size_t>(row.level)]},
                 {"meaning", row.meaning}};
  if (type < 2) {
    described["min"] = value_json(row, row.min);
    described["max"] = value_json(row, row.max);
  }
  if (row.type == ValueType::real) {
    described["units"] = units_description(row);
  }
  if (type == 2) {
    described["choices"] = row.choices;
  }
  return described;
}

json signal_description(std::size_t i) {
  const Signal<float>& row = signal_rows<float>[i];
  // The name ends in the unit, if there is one.
  constexpr std::array<std::string_view, 9> units{"_m_s", "_ohm", "_Pa", "_K", "_W",
                                                  "_A",   "_V",   "_m",  "_N"};
  const auto* const found =
      std::ranges::find_if(units, [&](std::string_view unit) { return row.name.ends_with(unit); });
  const std::string_view unit = found == units.end() ? "" : found->substr(1);
  json described{{"name", row.name}, {"unit", unit}, {"meaning", row.meaning}};
  if (i == limit_reason_signal) {
    json bits = json::array();
    for (unsigned bit = 0; bit < static_cast<unsigned>(LimitReason::count); ++bit) {
      bits.push_back(text::limit_reason_name(LimitReason(bit)));
    }
    described["bits"] = bits;
  }
  return described;
}

}  // namespace

json json_number(float value) {
  if (!std::isfinite(value)) {
    return nullptr;
  }
  const std::string text = fmt::format("{}", value);
  double number = 0;
  std::from_chars(text.data(), text.data() + text.size(), number);
  return number;
}

std::string json_text(const json& value) {
  return value.dump(-1, ' ', false, json::error_handler_t::replace);
}

json described() {
  json all{{"version", SMASERVO_VERSION}};
  for (const Parameter<double>& row : parameters<double>) {
    all["parameters"].push_back(parameter_description(row));
  }
  for (std::size_t i = 0; i < signal_count; ++i) {
    all["signals"].push_back(signal_description(i));
  }
  for (const FaultRow& row : fault_rows) {
    all["faults"].push_back({{"name", row.name},
                             {"code", fmt::format("{:04X}h", row.code)},
                             {"class", class_name(row.severity)},
                             {"text", text::explain_fault(row.fault)}});
  }
  for (const ModeRow& row : mode_rows()) {
    all["modes"].push_back({{"mode", row.mode}, {"name", row.name}, {"unit", row.unit}});
  }
  return all;
}

std::string live_text(const Sample& sample) {
  std::string text = "{";
  for (std::size_t i = 0; i < signal_count; ++i) {
    if (!sample.has[i]) {
      continue;
    }
    fmt::format_to(std::back_inserter(text), "{}\"{}\":", text.size() > 1 ? "," : "",
                   signal_rows<float>[i].name);
    if (std::isfinite(sample.values[i])) {
      fmt::format_to(std::back_inserter(text), "{}", sample.values[i]);
    } else {
      text += "null";
    }
  }
  return text + "}";
}

std::string live_bytes(const Sample& sample) {
  // CDR header: two bytes say that the rest is little-endian, two are unused.
  std::string bytes{0, 1, 0, 0};
  for (std::size_t i = 0; i < signal_count; ++i) {
    const float value = sample.has[i] ? sample.values[i] : std::numeric_limits<float>::quiet_NaN();
    auto bits = std::bit_cast<std::uint32_t>(value);
    for (std::size_t byte = 0; byte < sizeof bits; ++byte, bits >>= 8U) {
      bytes.push_back(static_cast<char>(bits & 0xFFU));
    }
  }
  return bytes;
}

json history_message(const HistoryRows& rows, std::int64_t wall_ns_at_0) {
  json message{{"t_ns", json::array()}};
  for (const std::int64_t time_us : rows.time_us) {
    message["t_ns"].push_back(wall_ns_at_0 + 1000 * time_us);
  }
  std::size_t column = 0;
  for (std::size_t i = 0; i < signal_count; ++i) {
    if (!rows.has[i]) {
      continue;
    }
    json& values = message[std::string(signal_rows<float>[i].name)] = json::array();
    for (const float value : rows.columns[column]) {
      values.push_back(json_number(value));
    }
    ++column;
  }
  return message;
}

json recording_message(const can::Recording& recording) {
  json rows = json::array();
  for (const std::vector<double>& row : recording.rows) {
    json values = json::array();
    for (const double value : row) {
      values.push_back(json_number(static_cast<float>(value)));
    }
    rows.push_back(std::move(values));
  }
  return {{"period_s", json_number(static_cast<float>(recording.period_s))},
          {"signals", recording.signals},
          {"rows", std::move(rows)}};
}

std::string parameter_json(const Parameter<double>& row, Value value) {
  return json_text(value_json(row, value));
}

std::string parameter_text(const Parameter<double>& row, const json& value) {
  const auto refuse = [&](const char* wanted) {
    throw UserError(fmt::format("{} = {}: must be {}", row.path.text(),
                                files::printable(json_text(value)), wanted));
  };
  switch (row.type) {
    case ValueType::real:
      if (!value.is_number()) {
        refuse("a number");
      }
      return fmt::format("{}", value.get<double>());
    case ValueType::number:
      if (!value.is_number() || value.get<double>() != std::floor(value.get<double>()) ||
          value.get<double>() < 0 || value.get<double>() > 4294967295.0) {
        refuse("a whole number from 0 to 4294967295");
      }
      return fmt::format("{:.0f}", value.get<double>());
    case ValueType::boolean:
      if (!value.is_boolean()) {
        refuse("true or false");
      }
      return value.get<bool>() ? "true" : "false";
    case ValueType::choice:
      break;
  }
  if (!value.is_string()) {
    refuse(text::range_text(row).c_str());
  }
  return value.get<std::string>();
}

std::size_t parameter_row(const std::string& path) {
  const std::size_t row = find_parameter(path);
  if (row != no_parameter) {
    return row;
  }
  const text::KnownObject object = text::find_object(path);  // throws, naming similar names
  throw UserError(object.parameter != nullptr
                      ? fmt::format("{}: must be in its own unit: {}", files::printable(path),
                                    object.parameter->path.text())
                      : fmt::format("{}: is no parameter", files::printable(path)));
}

json difference_messages(const std::vector<can::Difference>& all) {
  json messages = json::array();
  for (const can::Difference& d : all) {
    messages.push_back({{"name", d.row->path.text()},
                        {"file", json::parse(parameter_json(*d.row, d.here))},
                        {"node", json::parse(parameter_json(*d.row, d.there))}});
  }
  return messages;
}

ParameterName parameter_of(const std::string& name) {
  const std::size_t dot = name.find('.');
  unsigned node = 0;
  const char* const first = name.data() + 4;
  if (!name.starts_with("node") || dot == std::string::npos ||
      std::from_chars(first, name.data() + dot, node).ptr != name.data() + dot || node < 1 ||
      node > 127) {
    throw UserError(fmt::format("{}: must be nodeN.GROUP.NAME, such as node1.limits.current_A",
                                files::printable(name)));
  }
  return {node, parameter_row(name.substr(dot + 1))};
}

}  // namespace smaservo::page
