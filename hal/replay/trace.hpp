#pragma once
// Recorded traces: CSV with one header row, or MCAP, read in one pass and constant memory.
// hal/replay/README.md has the formats.

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "model/files/error.hpp"

namespace smaservo::hal {

/// The columns that are understood. Others are kept as text.
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
  resistance,  ///< this and power: only where TraceOptions ask for them
  power,
  supply,  ///< from here on: only where TraceOptions ask for a device's columns
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

struct TraceOptions {
  /// Skip and count bad rows instead of refusing them. Where the clock falls back and goes on from
  /// there, a new piece begins (TraceRow::piece).
  bool lenient = false;
  double period_s = 0;  ///< above 0: the rows' distance in time where no column has the time
  /// Columns under another name: "time_s=step" or, with a factor, "time_s=step*5".
  std::vector<std::string> renames;
  /// Read `resistance` and `power` as well; otherwise they are columns like any other, kept as
  /// text.
  bool resistance_and_power = false;
  /// Read the columns that only a device needs as well. An empty field then is a reading that was
  /// not taken: NaN.
  bool device = false;
};

/// One row, in SI; NaN where the trace has no such column.
struct TraceRow {
  std::array<double, column_count> values;
  std::string_view text;  ///< the row as CSV, without the line's end; valid until the next row
  std::uint64_t number;   ///< among all rows, bad ones as well; the first is 0
  std::uint32_t piece;    ///< how often the clock began anew before this row; times go on rising

  double operator[](Column column) const { return values[static_cast<std::size_t>(column)]; }
};

class TraceReader {
 public:
  /// `path` "-" is standard input. Reads and checks the header. A file that begins with MCAP's
  /// magic bytes is MCAP, and one whose name ends in .mcap must be. Throws TraceError.
  TraceReader(const std::string& path, TraceOptions options);
  ~TraceReader();
  TraceReader(const TraceReader&) = delete;
  TraceReader& operator=(const TraceReader&) = delete;
  TraceReader(TraceReader&&) noexcept;
  TraceReader& operator=(TraceReader&&) noexcept;

  bool has(Column column) const;
  /// Whether the rows have times, from a column or the options' period.
  bool timed() const;
  /// The name in the file of a column that it has.
  const std::string& name(Column column) const;
  /// The names of all columns, as read.
  const std::vector<std::string>& names() const;
  /// Positions of the columns that are not understood, to be copied.
  const std::vector<std::size_t>& unknown() const;

  /// Reads the next row; false at the end. Throws TraceError for a bad row, unless lenient; at the
  /// end also when lenient, where more rows were bad than good.
  bool next(TraceRow& row);

  std::uint64_t rows() const;  ///< good rows so far; when lenient, some more may be read already
  /// Bad rows so far, when lenient; and 1 for the rest of an MCAP file that was not finished.
  std::uint64_t skipped() const;
  std::uint64_t bytes() const;      ///< read so far
  std::uint64_t file_size() const;  ///< 0 where it is not known
  /// Why the first few skipped rows were bad.
  const std::vector<std::string>& complaints() const;
  /// Where the clock fell back, and what was made of it: the first few.
  const std::vector<std::string>& clock_notes() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace smaservo::hal
