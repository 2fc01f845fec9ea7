#pragma once
// Numbers and times of cells as text.

#include <string>
#include <string_view>

namespace smaservo::hal {

/// The shortest text that is read to the same number; empty of NaN.
std::string number_text(double value);

/// What a format of cells makes of a number.
enum class CellFormat { number, date, clock };

/// Of a format as Excel writes it, `yyyy-mm-dd hh:mm:ss.00`: a date where it shows a day or a year,
/// a clock where it shows hours or seconds alone.
CellFormat format_of(std::string_view code);
/// Of a format that Excel has built in.
CellFormat built_in_format(int number);

/// The number as a cell of this format shows it: `2026-11-28 12:30:05.25` or `12:30:05.25`. A
/// number that is no time of these is written as a number. `days` counts from 1899-12-30, or from
/// 1904-01-01. To 10 us, of a clock 1 us: a date in days has no more digits.
std::string cell_text(double days, CellFormat format, bool since_1904);

}  // namespace smaservo::hal
