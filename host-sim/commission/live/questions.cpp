#include "host-sim/commission/live/questions.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fmt/format.h>

#include "model/files/message.hpp"

namespace smaservo::commission {
namespace {

/// Greatest contraction as a share of the length: no NiTi wire makes more than 8 %, and a length or
/// a zero may be a little off.
constexpr double most_contraction = 0.10;
/// Greatest reading. Beyond it the unit was not millimetres.
constexpr double most_reading_mm = 10'000;

std::string_view trimmed(std::string_view text) {
  const auto is_blank = [](char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; };
  while (!text.empty() && is_blank(text.front())) {
    text.remove_prefix(1);
  }
  while (!text.empty() && is_blank(text.back())) {
    text.remove_suffix(1);
  }
  return text;
}

}  // namespace

std::optional<double> reading_mm(std::string_view typed) {
  std::string_view rest = trimmed(typed);
  if (rest.ends_with("mm")) {
    rest = trimmed(rest.substr(0, rest.size() - 2));
  }
  if (rest.starts_with('+') && !rest.starts_with("+-")) {
    rest.remove_prefix(1);
  }
  std::string number(rest);
  std::ranges::replace(number, ',', '.');
  double value = 0;
  const char* const end = number.data() + number.size();
  const auto [stopped, error] =
      std::from_chars(number.data(), end, value, std::chars_format::fixed);
  if (error != std::errc() || stopped != end || !(std::abs(value) <= most_reading_mm)) {
    return {};
  }
  return value;
}

std::string Readings::take(double time_s, double reading_m) {
  if (anchors_.empty()) {
    zero_m_ = reading_m;
    anchors_.push_back({time_s, 0, sd_m_});
    return "";
  }
  const double way_m = reading_m - zero_m_;
  if (std::abs(way_m) > most_contraction * wire_m_) {
    return fmt::format(
        "{:g} mm is {:.3g} mm from the cold reading, {:g} mm; a wire of {:.0f} mm moves by at most "
        "{:.3g} mm",
        1e3 * reading_m, 1e3 * std::abs(way_m), 1e3 * zero_m_, 1e3 * wire_m_,
        1e3 * most_contraction * wire_m_);
  }
  // Less than the readings' own errors has no sign.
  const bool has_sign = std::abs(way_m) > 2 * sd_m_;
  const double sign = way_m < 0 ? -1 : 1;
  if (has_sign && sign_ == 0) {
    sign_ = sign;
  }
  if (has_sign && sign != sign_) {
    return fmt::format(
        "{:g} mm is on the other side of the cold reading, {:g} mm, than the readings before: the "
        "wire would be longer than when it was cold",
        1e3 * reading_m, 1e3 * zero_m_);
  }
  anchors_.push_back({time_s, (sign_ == 0 ? 1 : sign_) * way_m, sd_m_});
  return "";
}

void Question::ask() {
  asked_ = true;
  person_.ask("displacement in mm (Enter: no reading): ", until_us_);
}

bool Question::look(std::int64_t now_us, double time_s) {
  if (!person_.is_there()) {
    return true;
  }
  if (now_us >= until_us_) {
    if (asked_) {
      person_.say("no reading in time; it goes on without");
    }
    return true;
  }
  if (!asked_) {
    ask();
  }
  const std::optional<std::string> typed = person_.typed();
  if (!typed) {
    return false;
  }
  if (trimmed(*typed).empty()) {
    person_.answered("");
    return true;
  }
  const std::optional<double> mm = reading_mm(*typed);
  const std::string objection =
      mm ? readings_.take(time_s, 1e-3 * *mm)
         : fmt::format("'{}' is no length in mm, such as 3.4", files::printable(*typed));
  person_.answered(objection);
  if (objection.empty()) {
    return true;
  }
  ask();
  return false;
}

}  // namespace smaservo::commission
