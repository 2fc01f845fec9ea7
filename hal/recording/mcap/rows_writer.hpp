#pragma once
// Makes an MCAP file of a trace's CSV text: a message for each row.

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "hal/recording/mcap/columns.hpp"
#include "hal/recording/mcap/writer.hpp"

namespace smaservo::hal::mcap {

/// Where a trace comes from; written to the file's metadata.
struct Origin {
  std::string program;  ///< name with its command: "host-sim simulate"
  std::string source;   ///< file, board or node
};

/// Takes CSV text in pieces of any length. All functions but take() throw UserError, which names
/// the line.
class RowsWriter {
 public:
  /// `kinds` may have fewer entries than the header has columns; for columns of unknown kind, the
  /// rows of the first 64 KiB decide between numbers and texts. A value that is no number is left
  /// out of a column of numbers, because the schema promises numbers. Where the trace's times fall
  /// back, log_time continues from the last time.
  RowsWriter(const Origin& origin, std::vector<Kind> kinds, bool compressed = true);

  void add(std::string_view csv);
  /// Ends the chunk, so that take() gives all rows so far.
  void flush();
  /// Ends the file. Refuses a last line without a line end, and times of which more than a tenth
  /// are not numbers.
  void finish();

  /// The next bytes of the file: whole records.
  std::string take() { return writer_.take(); }
  /// The number of rows in chunks that are closed.
  std::uint64_t closed() const { return writer_.closed(); }
  std::uint64_t rows() const { return rows_; }
  const TraceColumns& columns() const { return columns_; }
  /// What differs between the file and the text: one sentence for each column that lacks values,
  /// for times that fell back, for headers in the middle of the text.
  std::vector<std::string> remarks() const;

 private:
  struct Place {
    std::uint64_t count = 0, line = 0;  ///< number of occurrences, and line number of the first
    std::string text;                   ///< text of the first occurrence
    void add(std::uint64_t at, std::string_view what);
  };
  void line(std::string_view text);
  void header(std::string_view text);
  void row(std::string_view text);
  void begin();
  void encode(const std::vector<std::string_view>& fields, std::uint64_t line);
  void value(std::size_t column, std::string_view field, std::uint64_t line);
  std::uint64_t time_ns(const std::vector<std::string_view>& fields, std::uint64_t line);
  [[noreturn]] static void fail(std::uint64_t line, std::string_view what);

  Origin origin_;
  std::vector<Kind> kinds_;
  Writer writer_;
  TraceColumns columns_;
  std::size_t time_column_ = 0;  ///< equal to the number of columns if there is none
  double time_scale_ = 1;        ///< factor from the time column's unit to ns
  /// Added to times: after a negative first time, or after times that fell back.
  double shift_ns_ = 0;
  std::uint64_t last_ns_ = 0, gap_ns_ = 0, times_ = 0;
  std::string header_;
  /// Beginning of each column's JSON member: the quoted name and a colon.
  std::vector<std::string> names_;
  std::string rest_;        ///< beginning of a line whose end has not come yet
  std::string first_rows_;  ///< rows that wait until the kinds of all columns are known
  std::vector<std::uint64_t> first_lines_;  ///< line numbers of first_rows_
  bool has_header_ = false, begun_ = false;
  std::uint64_t lines_ = 0, rows_ = 0;
  std::vector<std::string_view> fields_;
  std::vector<FieldCounts> counts_;  ///< counts of each column's values in first_rows_
  std::vector<Place> left_out_;      ///< for each column: values that are no numbers
  Place falls_back_, headers_;
  std::string object_, number_;
};

}  // namespace smaservo::hal::mcap
