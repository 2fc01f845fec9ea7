#include "firmware/text/fault_reference.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <fmt/format.h>
#include <memory>
#include <optional>
#include <utility>

#include "firmware/safety/faults/table.hpp"
#include "model/files/similar.hpp"
#include "model/files/text_table.hpp"

namespace smaservo::text {
namespace {

constexpr std::string_view reaction(FaultClass severity) {
  switch (severity) {
    case FaultClass::F0:
      return "heat off, by the program and by the hardware";
    case FaultClass::F1:
      return "heat off";
    case FaultClass::F2:
      return "safe state, as safe.state says: off, hold for a time, or controlled release";
    case FaultClass::L:
      return "limiter: only the minimum current while the condition lasts";
    case FaultClass::B:
      return "blocks arming; a warning while running";
    case FaultClass::W:
      return "warning";
  }
  return "";
}

constexpr std::string_view clearing(Clears clears) {
  switch (clears) {
    case Clears::itself:
      return "by itself, when the condition has gone";
    case Clears::command:
      return "by the command to clear faults, when the condition has gone";
    case Clears::acknowledge:
      return "by the command to clear faults, which acknowledges it";
    case Clears::reset:
      return "by a restart";
  }
  return "";
}

std::string deglitch(const FaultRow& row) {
  if (const std::string_view setting = time_setting(row.fault); !setting.empty()) {
    return fmt::format("after {}", setting);
  }
  if (row.deglitch_s == 0) {
    return "at once";
  }
  return row.deglitch_s < 1 ? fmt::format("after {:g} ms", 1e3 * row.deglitch_s)
                            : fmt::format("after {:g} s", row.deglitch_s);
}

std::optional<unsigned> number(std::string_view digits, int base) {
  unsigned value = 0;
  const char* end = std::to_address(digits.end());
  const auto [last, error] = std::from_chars(std::to_address(digits.begin()), end, value, base);
  return error == std::errc{} && last == end ? std::optional(value) : std::nullopt;
}

std::optional<unsigned> code(std::string_view text) {
  if (text.starts_with("0x") || text.starts_with("0X")) {
    return number(text.substr(2), 16);
  }
  if (text.ends_with('h') || text.ends_with('H')) {
    return number(text.substr(0, text.size() - 1), 16);
  }
  return number(text, 10);
}

}  // namespace

std::string fault_reference() {
  files::TextTable classes({{"class"}, {"what follows"}});
  for (std::size_t i = 0; i < fault_class_count; ++i) {
    const auto severity = static_cast<FaultClass>(i);
    classes.add({class_name(severity), reaction(severity)});
  }
  files::TextTable faults({{"fault"}, {"code"}, {"class"}, {"time"}, {"what it is"}});
  for (const FaultRow& row : fault_rows) {
    faults.add({fmt::format("[{0}](#{0})", row.name), fmt::format("{:04X}h", row.code),
                class_name(row.severity), deglitch(row), row.text});
  }
  std::string page = fmt::format(
      "# Faults\n\n"
      "Made by `host-sim describe faults` from the table of faults "
      "([faults/](../safety/faults/table.hpp)); "
      "the tests compare\nthe two. `host-sim explain FAULT` prints one of them.\n\n{}"
      "\nThe time says how long a condition must last, after the step that first sees it, before "
      "it "
      "is a fault.\n\n{}",
      classes.markdown(), faults.markdown());
  for (const FaultRow& row : fault_rows) {
    page += fmt::format(
        "\n## {}\n\n{}\n\n"
        "- Code {:04X}h, class {}: {}; {}.\n- Causes: {}\n- Check: {}\n- Cleared {}.\n",
        row.name, row.text, row.code, class_name(row.severity), reaction(row.severity),
        deglitch(row), row.causes, row.check, clearing(row.clears));
  }
  return page;
}

std::string explain_fault(Fault fault) {
  const FaultRow& row = fault_row(fault);
  return fmt::format(
      "{} ({:04X}h)\n  {}\n\n"
      "  reaction  {}: {}; {}\n  causes    {}\n  check     {}\n  cleared   {}\n",
      row.name, row.code, row.text, class_name(row.severity), reaction(row.severity), deglitch(row),
      row.causes, row.check, clearing(row.clears));
}

Fault find_fault(std::string_view name_or_code) {
  const std::optional<unsigned> wanted = code(name_or_code);
  std::string name(name_or_code);
  std::ranges::transform(name, name.begin(), [](unsigned char c) { return std::tolower(c); });
  const auto* row = std::ranges::find_if(fault_rows, [&](const FaultRow& r) {
    return r.name == name || (wanted && r.code == *wanted);
  });
  return row == fault_rows.end() ? Fault::none : row->fault;
}

std::vector<std::string> similar_faults(std::string_view name) {
  std::vector<std::string> names;
  names.reserve(fault_rows.size());
  for (const FaultRow& row : fault_rows) {
    names.emplace_back(row.name);
  }
  return files::similar(name, names);
}

}  // namespace smaservo::text
