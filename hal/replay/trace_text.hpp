#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include "model/files/mcap/rows_reader.hpp"

namespace smaservo::hal {

/// The text of a trace: what a CSV file has, or the rows of an MCAP file as CSV. All functions that
/// read throw files::UserError, which does not name the file.
class TraceText {
 public:
  /// `path` "-" is standard input. A file that begins with MCAP's magic bytes is MCAP, and one
  /// whose name ends in .mcap must be.
  explicit TraceText(const std::string& path);
  ~TraceText();
  TraceText(const TraceText&) = delete;
  TraceText& operator=(const TraceText&) = delete;

  /// Returns how many bytes; 0 at the end.
  std::size_t read(char* to, std::size_t room);

  bool is_mcap() const { return mcap_ != nullptr; }
  /// What messages call a line of the text, counted from 1.
  std::string place(std::uint64_t line) const;
  /// Where an MCAP file ends that was not finished, after the end; else empty.
  std::string cut_off() const { return mcap_ ? mcap_->cut_off() : ""; }
  std::uint64_t bytes() const { return bytes_; }  ///< read of the file
  std::uint64_t size() const { return size_; }    ///< of the file; 0 where it is not known

 private:
  void open_file(const std::string& path);
  void read_head();
  std::size_t read_file(char* to, std::size_t room);

  int file_ = -1;
  std::uint64_t size_ = 0, bytes_ = 0;
  std::string head_;                              ///< first bytes of the file, which say what it is
  std::unique_ptr<files::mcap::CsvOfRows> mcap_;  ///< null: the file is CSV
};

}  // namespace smaservo::hal
