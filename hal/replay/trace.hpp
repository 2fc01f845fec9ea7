#pragma once
// Recorded traces: CSV with one header row, or MCAP, read in one pass and constant memory.
// hal/replay/README.md has the formats.

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "model/files/error.hpp"

namespace smaservo::hal {

/// The columns that the reader understands. Others are kept as text.
enum class Column : unsigned char {
  time,
  current,
  voltage,
  load,
  stress,
  temperature,
  ambient,
  strain_ref,
  displacement,
  resistance,  ///< this and both powers: read only if TraceOptions ask for them
  power,       ///< of a calorimeter, per mass
  heating,     ///< electrical power, where there are no current and voltage
  supply,      ///< this and the following: read only if TraceOptions ask for a device's columns
  driver,
  emergency_stop,
  driver_fault,
  sequence,
  fresh,
  count
};
inline constexpr std::size_t column_count = static_cast<std::size_t>(Column::count);

/// An error in a trace; the text names file, line and column.
class TraceError : public files::Error {
 public:
  using Error::Error;
};

/// How a recording is read.
struct TraceOptions {
  /// Skip and count bad rows instead of refusing them. If the clock falls back and continues from
  /// there, a new piece begins (TraceRow::piece).
  bool lenient = false;
  double period_s = 0;  ///< above 0: time from row to row, used if no column has the time
  /// Columns under another name: "time_s=step" or, with a factor, "time_s=step*5"; or a quantity, a
  /// column by name or number, and its unit: "current=3:mA".
  std::vector<std::string> renames;
  /// Interpret `resistance` and both powers as well; otherwise they are kept as text like unknown
  /// columns.
  bool resistance_and_power = false;
  /// Interpret the columns that only a device needs as well. An empty field is then a reading that
  /// was not taken: NaN.
  bool device = false;
};

/// One row, in SI; NaN for columns that the trace does not have.
struct TraceRow {
  std::array<double, column_count> values;
  std::string_view text;  ///< the row as CSV without its line end; valid until the next row
  std::uint64_t number;   ///< number among all rows, including bad ones; the first is 0
  std::uint64_t line;     ///< line of the file, or message of an MCAP file
  /// Number of times that the clock restarted before this row; times continue to rise.
  std::uint32_t piece;

  /// The value of a column.
  double operator[](Column column) const { return values[static_cast<std::size_t>(column)]; }
  /// The row's time in whole nanoseconds, as observers get it.
  std::int64_t time_ns() const {
    return static_cast<std::int64_t>(std::llround((*this)[Column::time] * 1e9));
  }
};

/// Reads a recording row by row: CSV, also compressed, MCAP, tables of other programs,
/// spreadsheets.
class TraceReader {
 public:
  /// `path` "-" is standard input. Reads and checks the header. A file that begins with MCAP's
  /// magic bytes is read as MCAP; a file whose name ends in .mcap must begin with them. Throws
  /// TraceError.
  TraceReader(const std::string& path, TraceOptions options);
  ~TraceReader();
  TraceReader(const TraceReader&) = delete;
  TraceReader& operator=(const TraceReader&) = delete;
  TraceReader(TraceReader&&) noexcept;
  TraceReader& operator=(TraceReader&&) noexcept;

  /// Whether the recording has values for it, measured or computed from other columns.
  bool has(Column column) const;
  /// Whether the rows have times, from a column or the options' period.
  bool timed() const;
  /// The position of a column that the trace has, from 0; for a voltage that comes from a
  /// resistance, that column's.
  std::size_t position(Column column) const;
  /// The name that a column of the trace has in the file.
  const std::string& name(Column column) const;
  /// The names of all columns, as read.
  const std::vector<std::string>& names() const;
  /// The name of a column in this project's dialect, "current_mA" for 'I [mA]', and the factor that
  /// its numbers then need; the file's own name where it is not understood.
  std::string own_name(std::size_t column) const;
  /// The factor that the numbers of a column need under own_name().
  double scale(std::size_t column) const;
  /// A value of a column that the trace has, in the unit of own_name().
  double in_unit(Column column, double si) const;
  /// Positions of the columns that are not understood, to be copied.
  const std::vector<std::size_t>& unknown() const;

  /// What a row's `line` is the number of: "line", of an MCAP file "message", of a spreadsheet or a
  /// MATLAB file "row".
  std::string_view word() const;
  /// Reads the next row; false at the end. Throws TraceError for a bad row, unless lenient; if
  /// lenient, it throws at the end if more rows were bad than good.
  bool next(TraceRow& row);

  /// Good rows so far; a lenient reader may already have read a few more.
  std::uint64_t rows() const;
  /// Bad rows so far, if lenient; the missing rest of an unfinished MCAP file counts as 1.
  std::uint64_t skipped() const;
  std::uint64_t bytes() const;      ///< bytes read so far
  std::uint64_t file_size() const;  ///< bytes; 0 if not known
  /// The reasons why the first few skipped rows were bad.
  const std::vector<std::string>& complaints() const;
  /// Headers that came again among the rows, and were skipped.
  std::uint64_t repeated_headers() const;
  /// Lines among the rows of another program's table that are none, as a microcontroller's
  /// messages; they were skipped. More of them than rows are an error.
  std::uint64_t strays() const;
  /// The first of them: "line 17: 'ets Jun  8 2016'"; empty: there are none.
  std::string first_stray() const;
  /// How the table of another program was read: "separated by semicolons, names in line 3; time =
  /// column 1 'Time [s]' in s; ..."; empty where the file is of this project's dialect.
  std::string read_as() const;
  bool is_packed() const;  ///< the file is compressed
  /// What columns may mean that were not taken, and what to type: one sentence each.
  const std::vector<std::string>& hints() const;
  /// The first few places where the clock fell back, and how they were treated.
  const std::vector<std::string>& clock_notes() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace smaservo::hal
