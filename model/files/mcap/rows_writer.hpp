#pragma once
// Makes an MCAP file of a trace's CSV text: a message for each row.

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "model/files/mcap/columns.hpp"
#include "model/files/mcap/writer.hpp"

namespace smaservo::files::mcap {

/// Where a trace comes from; stands in the file's metadata.
struct Origin {
  std::string program;  ///< as "host-sim simulate"
  std::string source;   ///< file, board or node
};

/// Takes CSV text in pieces of any length. All functions but take() throw UserError, which names
/// the line.
class RowsWriter {
 public:
  /// `kinds` may have fewer entries than the header; of the columns that are unknown, the rows of
  /// the first 64 KiB say whether they are numbers or texts. What is no number in a column of
  /// numbers is left out, as the schema says numbers. Times that fall back go on in log_time.
  RowsWriter(const Origin& origin, std::vector<Kind> kinds, bool compressed = true);

  void add(std::string_view csv);
  /// Ends the chunk: all rows so far are in what take() gives.
  void flush();
  /// Ends the file. Refuses a last line without its end, and times of which more than a tenth are
  /// no numbers.
  void finish();

  /// The next bytes of the file: whole records.
  std::string take() { return writer_.take(); }
  /// Rows in chunks that are closed.
  std::uint64_t closed() const { return writer_.closed(); }
  std::uint64_t rows() const { return rows_; }
  const TraceColumns& columns() const { return columns_; }
  /// What is not in the file as it was in the text, or not where it seems: a sentence for each
  /// column that lacks values, for times that fell back, for headers in the middle.
  std::vector<std::string> remarks() const;

 private:
  struct Place {
    std::uint64_t count = 0, line = 0;  ///< how many, the first one's line
    std::string text;                   ///< of the first
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
  std::size_t time_column_ = 0;  ///< the number of columns: there is none
  double time_scale_ = 1;        ///< of it to ns
  double shift_ns_ = 0;          ///< added, where the first time is below 0, or times fell back
  std::uint64_t last_ns_ = 0, gap_ns_ = 0, times_ = 0;
  std::string header_;
  std::vector<std::string> names_;          ///< as members of an object: "name":
  std::string rest_;                        ///< of a line that is not whole yet
  std::string first_rows_;                  ///< until the kinds are known
  std::vector<std::uint64_t> first_lines_;  ///< of these
  bool has_header_ = false, begun_ = false;
  std::uint64_t lines_ = 0, rows_ = 0;
  std::vector<std::string_view> fields_;
  std::vector<FieldCounts> counts_;  ///< of the first rows
  std::vector<Place> left_out_;      ///< for each column
  Place falls_back_, headers_;
  std::string object_, number_;
};

}  // namespace smaservo::files::mcap
