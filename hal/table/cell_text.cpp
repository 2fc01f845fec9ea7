#include "hal/table/cell_text.hpp"

#include <chrono>
#include <cmath>
#include <fmt/format.h>
#include <iterator>

namespace smaservo::hal {
namespace {

constexpr long long us_of_day = 86'400'000'000;

std::string clock_text(long long us) {
  const long long s = us / 1'000'000;
  std::string text = fmt::format("{:02}:{:02}:{:02}", s / 3600, s / 60 % 60, s % 60);
  if (const long long rest = us % 1'000'000; rest > 0) {
    text += fmt::format(".{:06}", rest);
    text.erase(text.find_last_not_of('0') + 1);
  }
  return text;
}

}  // namespace

std::string number_text(double value) {
  return std::isnan(value) ? "" : fmt::format("{}", value);
}

CellFormat format_of(std::string_view code) {
  bool clock = false;
  for (std::size_t i = 0; i < code.size() && code[i] != ';'; ++i) {
    const char c = code[i];
    if (c == '"') {
      i = std::min(code.find('"', i + 1), code.size() - 1);
    } else if (c == '\\' || c == '_' || c == '*') {
      ++i;
    } else if (c == '[') {
      // [h] are hours beyond 24; [Red] and [$-409] are no times.
      const std::size_t end = std::min(code.find(']', i), code.size() - 1);
      const std::string_view inside = code.substr(i + 1, end - i - 1);
      clock = clock ||
              (!inside.empty() && inside.find_first_not_of("hHmMsS") == std::string_view::npos);
      i = end;
    } else if (c == 'y' || c == 'Y' || c == 'd' || c == 'D') {
      return CellFormat::date;
    } else if (c == 'h' || c == 'H' || c == 's' || c == 'S') {
      clock = true;
    } else if (code.substr(i).starts_with("General")) {
      return CellFormat::number;
    }
  }
  return clock ? CellFormat::clock : CellFormat::number;
}

CellFormat built_in_format(int number) {
  const bool date = (14 <= number && number <= 17) || number == 22 ||
                    (27 <= number && number <= 31) || (50 <= number && number <= 58) ||
                    number == 36;
  const bool clock = (18 <= number && number <= 21) || (45 <= number && number <= 47) ||
                     (32 <= number && number <= 35);
  return date ? CellFormat::date : clock ? CellFormat::clock : CellFormat::number;
}

std::string cell_text(double days, CellFormat format, bool since_1904) {
  // A clock beyond 99 hours is none; the last date is in the year 9999.
  const bool clock = format == CellFormat::clock && 0 <= days && days < 100.0 / 24;
  const bool date = format == CellFormat::date && 0 <= days && days < 2'958'000;
  if (!clock && !date) {
    return number_text(days);
  }
  if (clock) {
    return clock_text(std::llround(days * us_of_day));
  }
  constexpr long long us = 10;
  constexpr long long parts_of_day = us_of_day / us;
  const long long all = std::llround(days * parts_of_day) * us;
  const auto epoch = since_1904 ? std::chrono::sys_days(std::chrono::January / 1 / 1904)
                                : std::chrono::sys_days(std::chrono::December / 30 / 1899);
  const std::chrono::year_month_day day(epoch + std::chrono::days(all / us_of_day));
  return fmt::format("{:04}-{:02}-{:02} {}", static_cast<int>(day.year()),
                     static_cast<unsigned>(day.month()), static_cast<unsigned>(day.day()),
                     clock_text(all % us_of_day));
}

}  // namespace smaservo::hal
