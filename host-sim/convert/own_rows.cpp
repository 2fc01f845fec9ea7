#include "host-sim/convert/own_rows.hpp"

#include <algorithm>
#include <charconv>
#include <fmt/format.h>

namespace smaservo::convert {
namespace {

/// The field's number times the factor; the field itself where it is no number.
std::string scaled(std::string_view field, double factor) {
  double value = 0;
  const char* const stop = field.data() + field.size();
  // `stop` is where it ends. NOLINTNEXTLINE(bugprone-suspicious-stringview-data-usage)
  const auto [at, error] = std::from_chars(field.data(), stop, value);
  return error == std::errc{} && at == stop ? fmt::format("{}", value * factor)
                                            : std::string(field);
}

hal::TraceOptions with(const std::vector<std::string>& renames) {
  hal::TraceOptions options;
  options.renames = renames;
  // Resistance and power have names, too.
  options.resistance_and_power = true;
  return options;
}

}  // namespace

std::string own_header(const hal::TraceReader& trace) {
  std::string text;
  for (std::size_t i = 0; i < trace.names().size(); ++i) {
    text += (i > 0 ? "," : "") + trace.own_name(i);
  }
  return text;
}

void add_own_row(const hal::TraceReader& trace, const hal::TraceRow& row, std::string& text) {
  std::string_view rest = row.text;
  for (std::size_t i = 0; i < trace.names().size(); ++i) {
    const std::string_view field = rest.substr(0, rest.find(','));
    rest.remove_prefix(std::min(field.size() + 1, rest.size()));
    text += i > 0 ? "," : "";
    text += trace.scale(i) == 1 ? std::string(field) : scaled(field, trace.scale(i));
  }
}

OwnRows::OwnRows(const std::string& path, const std::vector<std::string>& renames)
    : trace_(path, with(renames)), text_(own_header(trace_) + '\n') {}

std::size_t OwnRows::read(char* to, std::size_t room) {
  while (given_ == text_.size()) {
    text_.clear();
    given_ = 0;
    hal::TraceRow row{};
    if (!trace_.next(row)) {
      return 0;
    }
    add_own_row(trace_, row, text_);
    text_ += '\n';
  }
  const std::size_t part = text_.copy(to, room, given_);
  given_ += part;
  return part;
}

}  // namespace smaservo::convert
