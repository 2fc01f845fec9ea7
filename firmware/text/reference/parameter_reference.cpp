#include "firmware/text/reference/parameter_reference.hpp"

#include <fmt/format.h>

#include "firmware/parameters/parameter_check.hpp"
#include "firmware/parameters/schemas.hpp"
#include "firmware/text/settings_text.hpp"

namespace smaservo {
namespace {

using Row = Parameter<double>;

std::string_view type_text(ValueType type) {
  switch (type) {
    case ValueType::real:
      return "REAL32";
    case ValueType::number:
      return "UNSIGNED32";
    case ValueType::choice:
      return "UNSIGNED8";
    case ValueType::boolean:
      break;
  }
  return "BOOLEAN";
}

std::string_view change_text(Change change) {
  switch (change) {
    case Change::live:
      return "live";
    case Change::without_current:
      return "not enabled";
    case Change::after_reset:
      break;
  }
  return "after reset";
}

std::string row_text(const Row& row) {
  return fmt::format("| {:04X}h:{} | `{}` | {} | {} | {} | {} | {} |\n", row.key.index, row.key.sub,
                     row.path.text(), type_text(row.type), range_text(row),
                     row.has_default() ? value_text(row, row.standard) : "none",
                     change_text(row.change), row.meaning);
}

std::string rule_text(const Rule& rule) {
  const auto path = [](std::size_t i) {
    return fmt::format("`{}`", parameters<double>[i].path.text());
  };
  std::string left =
      rule.factor == 1 ? path(rule.a) : fmt::format("{} {}", rule.factor, path(rule.a));
  if (rule.plus < parameter_count) {
    left += " + " + path(rule.plus);
  }
  const std::string_view sign = rule.relation == Relation::below       ? "<"
                                : rule.relation == Relation::not_above ? "<="
                                                                       : "with";
  return fmt::format("| {} {} {} | {} |\n", left, sign, path(rule.b), rule.meaning);
}

}  // namespace

std::string parameter_reference() {
  std::string out = fmt::format(
      "# Parameters\n\nMade by `host-sim describe parameters` from "
      "firmware/parameters/parameters.hpp; not to "
      "be edited.\nSchema {}, hash {:08X}h. Values are those of a float, in the SI unit that ends "
      "the path; a file\nmay use another unit of the same kind. *Not enabled*: refused while there "
      "may be current. *After\nreset*: stored, in force after the next start. The wire has no "
      "defaults: without one the device is\nnot configured.\n",
      released_schemas.back().version, schema_hash<double>(parameter_rows<double>));
  std::string_view open;
  for (const Row& row : parameters<double>) {
    const std::string_view path = row.path.text();
    const std::string_view table = path.substr(0, path.rfind('.'));
    if (table != open) {
      open = table;
      out += fmt::format(
          "\n## {}\n\n| Key | Path | Type | Range | Default | Change | Meaning "
          "|\n|---|---|---|---|---|---|---|\n",
          table);
    }
    out += row_text(row);
  }
  out +=
      "\n## As a set\n\nA set that breaks one of these rules is refused, and both parameters are "
      "named.\n\n| Rule | Why |\n|---|---|\n";
  for (const Rule& rule : parameter_rules) {
    out += rule_text(rule);
  }
  return out;
}

}  // namespace smaservo
