#include "host-sim/settings_text.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace smaservo {
namespace {

/// The shortest text that is this float when it is read as a double and rounded.
std::string shortest(float value) {
  const std::string text = fmt::format("{}", value);
  return static_cast<float>(std::stod(text)) == value
             ? text
             : fmt::format("{}", static_cast<double>(value));
}

}  // namespace

KeyParts key_parts(const Parameter<double>& row) {
  const std::string_view path = row.path.text();
  const std::size_t dot = path.rfind('.');
  const std::string_view suffix = row.kind.front().suffix;
  std::string_view name = path.substr(dot + 1);
  name.remove_suffix(suffix.empty() ? 0 : suffix.size() + 1);
  return {path.substr(0, dot), name};
}

std::string key_with(std::string_view name, const Unit& unit) {
  return unit.suffix.empty() ? std::string(name) : fmt::format("{}_{}", name, unit.suffix);
}

std::string value_text(const Parameter<double>& row, Value value) {
  switch (row.type) {
    case ValueType::real:
      return shortest(value.real());
    case ValueType::number:
      return fmt::format("{}", value.number());
    case ValueType::choice:
      return std::string(row.choices[value.number()]);
    case ValueType::boolean:
      break;
  }
  return value.number() != 0 ? "true" : "false";
}

std::string range_text(const Parameter<double>& row) {
  switch (row.type) {
    case ValueType::choice:
      return fmt::format("{}", fmt::join(row.choices, ", "));
    case ValueType::boolean:
      return "true, false";
    case ValueType::real:
    case ValueType::number:
      break;
  }
  return fmt::format("{} to {}", value_text(row, row.least), value_text(row, row.greatest));
}

}  // namespace smaservo
