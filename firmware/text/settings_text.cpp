#include "firmware/text/settings_text.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <utility>
#include <vector>

namespace smaservo::text {
namespace {

/// Signs in units, in UTF-8: the degree, the micro sign, the Greek letter mu.
constexpr auto spellings = std::to_array<std::pair<std::string_view, std::string_view>>(
    {{"\xC2\xB0", "deg"}, {"\xC2\xB5", "u"}, {"\xCE\xBC", "u"}});

/// The shortest text that gives this float when it is read as a double and rounded.
std::string shortest(float value) {
  const std::string text = fmt::format("{}", value);
  return static_cast<float>(std::stod(text)) == value
             ? text
             : fmt::format("{}", static_cast<double>(value));
}

std::optional<Value> value_of(const Parameter<double>& row, std::string_view text) {
  const char* const start = text.data();
  const char* const stop = start + text.size();
  if (row.type == ValueType::real) {
    float value = 0;
    const auto [at, error] = std::from_chars(start, stop, value);
    return error == std::errc{} && at == stop ? std::optional(Value::real(value)) : std::nullopt;
  }
  if (row.type == ValueType::number) {
    std::uint32_t value = 0;
    const auto [at, error] = std::from_chars(start, stop, value);
    return error == std::errc{} && at == stop ? std::optional(Value::number(value)) : std::nullopt;
  }
  static constexpr std::array<std::string_view, 2> flags{"false", "true"};
  const std::span<const std::string_view> names =
      row.type == ValueType::choice ? row.choices : std::span<const std::string_view>(flags);
  for (std::uint32_t i = 0; i < names.size(); ++i) {
    if (names[i] == text) {
      return Value::number(i);
    }
  }
  return std::nullopt;
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

std::optional<Unit> Quantity::unit_in(Kind kind, const Unit& plain) const {
  if (unit.empty()) {
    return plain;
  }
  std::string suffix(unit == "%" ? "percent" : unit);
  for (const auto& [sign, letters] : spellings) {
    for (std::size_t at = 0; (at = suffix.find(sign, at)) != std::string::npos;) {
      suffix.replace(at, sign.size(), letters);
    }
  }
  if (suffix.starts_with('/')) {
    suffix.insert(0, 1, '1');
  }
  std::ranges::replace(suffix, '/', '_');
  const auto found = std::ranges::find(kind, suffix, &Unit::suffix);
  return found == kind.end() ? std::nullopt : std::optional(*found);
}

std::optional<Quantity> quantity_of(std::string_view text) {
  Quantity quantity{};
  // from_chars() takes no plus.
  if (text.size() > 1 && text.front() == '+' && text[1] != '-') {
    text.remove_prefix(1);
  }
  const char* const start = text.data();
  const auto [end, error] = std::from_chars(start, start + text.size(), quantity.number);
  if (error != std::errc{}) {
    return std::nullopt;
  }
  const auto used = static_cast<std::size_t>(end - start);
  quantity.unit = text.substr(std::min(text.find_first_not_of(' ', used), text.size()));
  return quantity;
}

std::string suffixes_text(Kind kind) {
  std::vector<std::string_view> suffixes;
  for (const Unit& unit : kind) {
    if (!unit.suffix.empty()) {
      suffixes.push_back(unit.suffix);
    }
  }
  return fmt::format("{}", fmt::join(suffixes, ", "));
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
  return fmt::format("{} to {}", value_text(row, row.min), value_text(row, row.max));
}

std::string changes_text(const Settings<double>& from, const Settings<double>& to) {
  std::string text;
  for (const Parameter<double>& row : parameters<double>) {
    const Value value = row.get(to);
    if (row.get(from) != value) {
      text +=
          fmt::format("{}{}={}", text.empty() ? "" : ";", row.path.text(), value_text(row, value));
    }
  }
  return text;
}

std::string apply_changes(std::string_view text, Settings<double>& settings) {
  Settings<double> changed = settings;
  while (!text.empty()) {
    const std::string_view one = text.substr(0, text.find(';'));
    text.remove_prefix(std::min(text.size(), one.size() + 1));
    const std::size_t equals = std::min(one.find('='), one.size());
    const std::size_t i = find_parameter(one.substr(0, equals));
    if (i == no_parameter) {
      const std::string now = files::renamed_key(one.substr(0, equals));
      return find_parameter(now) == no_parameter
                 ? fmt::format("has an unknown parameter '{}'", one.substr(0, equals))
                 : fmt::format("has '{}', which is now called {}", one.substr(0, equals), now);
    }
    const std::string_view said = one.substr(std::min(equals + 1, one.size()));
    const std::optional<Value> value = value_of(parameters<double>[i], said);
    if (!value) {
      return fmt::format("has {} = '{}': must be {}", one.substr(0, equals), said,
                         range_text(parameters<double>[i]));
    }
    parameters<double>[i].set(changed, *value);
  }
  settings = changed;
  return {};
}

}  // namespace smaservo::text
