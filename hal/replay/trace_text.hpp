#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "hal/recording/foreign_table.hpp"
#include "hal/recording/mcap/rows_reader.hpp"
#include "hal/recording/unpacked.hpp"
#include "hal/replay/sheet/sheet.hpp"

namespace smaservo::hal {

/// The text of a trace: the content of a CSV file, or the rows of an MCAP file, of another
/// program's table, of a spreadsheet or a MATLAB file as CSV. All functions that read throw
/// files::UserError, which does not name the file.
class TraceText {
 public:
  /// `path` "-" is standard input. A file that begins with MCAP's magic bytes is read as MCAP; a
  /// file whose name ends in .mcap must begin with them.
  explicit TraceText(const std::string& path);
  ~TraceText();
  TraceText(const TraceText&) = delete;
  TraceText& operator=(const TraceText&) = delete;

  /// Returns the number of bytes; 0 at the end.
  std::size_t read(char* to, std::size_t room);

  bool is_mcap() const { return mcap_ != nullptr; }
  bool is_packed() const { return content_->is_packed(); }  ///< the file is compressed
  /// The name of a line of the text in messages; lines are counted from 1.
  std::string place(std::uint64_t line) const;
  /// Its parts: "line", "message" or "row", and the number.
  std::string_view word() const;
  std::uint64_t number(std::uint64_t line) const;
  /// How another program's table is laid out; empty for a CSV file of this project's dialect.
  std::string layout() const;
  /// Headers in the middle of the table, which are skipped.
  std::uint64_t repeated_headers() const { return sheet_ ? sheet_->repeated() : 0; }
  /// Lines among the rows of another program's table that are none, and the first of them.
  std::uint64_t strays() const { return sheet_ ? sheet_->strays() : 0; }
  std::string first_stray() const { return sheet_ ? sheet_->first_stray() : ""; }
  /// After the end: where an unfinished MCAP file ends; empty if it was finished.
  std::string cut_off() const { return mcap_ ? mcap_->cut_off() : ""; }
  std::uint64_t bytes() const { return bytes_; }  ///< bytes of the file read so far
  std::uint64_t size() const { return size_; }    ///< bytes of the file; 0 if not known

 private:
  void open_file(const std::string& path);
  std::size_t read_file(char* to, std::size_t room);
  void open_foreign();
  std::size_t read_foreign(char* to, std::size_t room);

  int file_ = -1;
  std::uint64_t size_ = 0, bytes_ = 0;
  std::unique_ptr<Unpacked> content_;
  std::unique_ptr<ForeignTable> table_;    ///< null: the file is no spreadsheet or MATLAB file
  std::unique_ptr<mcap::CsvOfRows> mcap_;  ///< null: the file is text
  std::unique_ptr<CsvOfSheet> sheet_;      ///< null: the file is MCAP
};

}  // namespace smaservo::hal
