#include "hal/recording/mcap/columns.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <set>

#include "hal/recording/mcap/row_object.hpp"
#include "hal/recording/trimmed.hpp"
#include "model/files/error.hpp"

namespace smaservo::hal::mcap {
namespace {

Kind kind_of(const nlohmann::ordered_json& property) {
  const auto type = property.is_object() ? property.find("type") : property.end();
  if (!property.is_object() || type == property.end()) {
    return Kind::unknown;
  }
  return *type == "number" || *type == "integer" || *type == "boolean" ? Kind::number : Kind::text;
}

}  // namespace

std::vector<std::string> header_names(std::string_view header) {
  std::vector<std::string> names;
  for (std::size_t from = 0; from <= header.size();) {
    const std::size_t comma = std::min(header.find(',', from), header.size());
    names.emplace_back(trimmed(header.substr(from, comma - from)));
    from = comma + 1;
  }
  return names;
}

bool split_row(std::string_view row, std::size_t count, std::vector<std::string_view>& fields) {
  fields.clear();
  for (std::size_t from = 0; from <= row.size() && fields.size() <= count;) {
    const std::size_t comma = std::min(row.find(',', from), row.size());
    fields.push_back(row.substr(from, comma - from));
    from = comma + 1;
  }
  return fields.size() == count;
}

std::string_view as_number(std::string_view field, std::string& room) {
  if (is_json_number(field)) {
    return field;
  }
  const std::string_view digits = field.substr(field.starts_with('-') ? 1 : 0);
  const char* const start = field.data();
  const char* const stop = start + field.size();
  double value = 0;
  const auto [end, error] = std::from_chars(start, stop, value);
  if (field.empty() || error != std::errc{} || end != stop || !std::isfinite(value) ||
      (digits.size() > 1 && digits[0] == '0' && digits[1] >= '0' && digits[1] <= '9')) {
    return "";
  }
  std::array<char, 32> shortest{};
  room.assign(shortest.data(),
              std::to_chars(shortest.data(), shortest.data() + shortest.size(), value).ptr);
  return room;
}

bool says_no_value(std::string_view field) {
  constexpr std::size_t longest = 9;
  if (field.empty() || field.size() > longest) {
    return field.empty();
  }
  std::string lower(field);
  std::ranges::transform(lower, lower.begin(), [](unsigned char c) { return std::tolower(c); });
  const std::string_view name = std::string_view(lower).substr(
      lower.size() > 1 && (lower[0] == '-' || lower[0] == '+') ? 1 : 0);
  constexpr std::array<std::string_view, 8> names{"nan", "inf",  "infinity", "na",
                                                  "n/a", "null", "none",     "-"};
  return std::ranges::find(names, name) != names.end();
}

void FieldCounts::add(std::string_view field, std::uint64_t line) {
  std::string room;
  if (says_no_value(field)) {
    return;
  }
  if (!as_number(field, room).empty()) {
    ++numbers;
  } else if (texts++ == 0) {
    first_text_line = line;
    first_text = field;
  }
}

Kind FieldCounts::kind() const {
  if (numbers == 0) {
    return texts == 0 ? Kind::unknown : Kind::text;
  }
  return 9 * texts <= numbers ? Kind::number : Kind::text;
}

std::string schema_of(const TraceColumns& columns) {
  std::string schema = R"({"type":"object","title":"smaservo.Trace","properties":{)";
  std::set<std::string_view> names;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const std::string& name = columns[i].name;
    if (!names.insert(name).second) {
      throw files::UserError(
          fmt::format("column {} ({}): another one has this name; in an MCAP file each "
                      "must have its own",
                      i + 1, name));
    }
    schema += i == 0 ? "" : ",";
    if (!put_json_text(schema, name)) {
      throw files::UserError(fmt::format("column {}: its name is no UTF-8", i + 1));
    }
    schema += columns[i].kind == Kind::number ? R"(:{"type":"number"})" : R"(:{"type":"string"})";
  }
  return schema + "}}";
}

TraceColumns columns_of(std::string_view schema) {
  const auto json = nlohmann::ordered_json::parse(schema, nullptr, false);
  if (json.is_discarded() || !json.is_object()) {
    throw files::UserError("the schema is no JSON object");
  }
  TraceColumns columns;
  const auto properties = json.find("properties");
  if (properties != json.end() && properties->is_object()) {
    for (const auto& [name, property] : properties->items()) {
      columns.push_back({name, kind_of(property)});
    }
  }
  return columns;
}

}  // namespace smaservo::hal::mcap
