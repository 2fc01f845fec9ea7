#include "firmware/text/canopen/parameter_reference.hpp"

#include <fmt/format.h>

#include "firmware/parameters/parameter_check.hpp"
#include "firmware/parameters/schemas.hpp"
#include "firmware/text/canopen/object_list.hpp"
#include "firmware/text/settings_text.hpp"
#include "model/files/text_table.hpp"

namespace smaservo::text {
namespace {

using Row = Parameter<double>;

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

std::string rule_text(const Rule& rule) {
  const auto path = [](std::size_t i) {
    return fmt::format("`{}`", parameters<double>[i].path.text());
  };
  std::string left =
      rule.factor == 1 ? path(rule.a) : fmt::format("{} {}", rule.factor, path(rule.a));
  const bool compares = rule.relation == Relation::below || rule.relation == Relation::not_above;
  if (rule.plus < parameter_count) {
    left += (compares ? " + " : " and ") + path(rule.plus);
  }
  const std::string_view sign = rule.relation == Relation::below       ? "<"
                                : rule.relation == Relation::not_above ? "<="
                                                                       : "with";
  return fmt::format("{} {} {}", left, sign, path(rule.b));
}

/// The group of a path: all but its last part.
std::string_view group_of(const Row& row) {
  return row.path.text().substr(0, row.path.text().rfind('.'));
}

std::string group_text(std::string_view group) {
  files::TextTable table(
      {{"Key"}, {"Path"}, {"Type"}, {"Range"}, {"Default"}, {"Change"}, {"Level"}, {"Meaning"}});
  for (const Row& row : parameters<double>) {
    if (group_of(row) == group) {
      table.add({fmt::format("{:04X}h:{}", row.key.index, row.key.sub),
                 fmt::format("`{}`", row.path.text()), type_text(type_of(row.type)),
                 range_text(row), row.has_default() ? value_text(row, row.standard) : "none",
                 change_text(row.change), level_names[static_cast<std::size_t>(row.level)],
                 row.meaning});
    }
  }
  return fmt::format("\n## {}\n\n{}", group, table.markdown());
}

std::string rules_text() {
  files::TextTable table({{"Rule"}, {"Why"}});
  for (const Rule& rule : parameter_rules) {
    table.add({rule_text(rule), rule.meaning});
  }
  return table.markdown();
}

}  // namespace

std::string parameter_reference() {
  std::string out = fmt::format(
      "# Parameters\n\n"
      "Made by `host-sim describe parameters` from firmware/parameters/parameters.hpp; not to be "
      "edited.\n"
      "Schema {}, hash {:08X}h. A REAL32 is in the SI unit that ends its path; a file may use "
      "another unit of\n"
      "the same kind. Change: *live*, at any time; *not enabled*, refused while current may flow; "
      "*after reset*,\n"
      "stored and in force from the next start. Most numbers of the wire have no default: without "
      "them the device is not\n"
      "configured. On CANopen all parameters are rw and none is in a PDO; a choice is sent as its "
      "position in\n"
      "the range, counted from 0.\n",
      released_schemas.back().version, schema_hash<double>(parameter_rows<double>));
  std::string_view open;
  for (const Row& row : parameters<double>) {
    if (group_of(row) != open) {
      open = group_of(row);
      out += group_text(open);
    }
  }
  return out +
         "\n## As a set\n\nA set that breaks one of these rules is refused, and both parameters "
         "are "
         "named.\n\n" +
         rules_text();
}

}  // namespace smaservo::text
