#pragma once
// The rows of an MCAP file as CSV text.

#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "hal/recording/mcap/columns.hpp"
#include "hal/recording/mcap/reader.hpp"

namespace smaservo::hal::mcap {

/// Reads the messages of one channel whose encoding is json: each is an object and becomes a row.
/// The columns are those of the channel's JSON Schema, in its order; without a schema, those of the
/// first message. All functions throw UserError, which says where in the file.
class RowsReader {
 public:
  /// `topic` names the channel; empty: /trace, or otherwise the only topic that has messages.
  RowsReader(Reader::Source source, std::string topic);

  /// The columns; reads up to the first message.
  const TraceColumns& columns();
  /// The header without its end.
  std::string header();
  /// Appends the next row, without its end; false after the last.
  bool next(std::string& row);

  const std::string& cut_off() const { return reader_.cut_off(); }

 private:
  bool next_message(Message& message);
  bool is_chosen(const Channel& channel) const;
  void choose(const Message& message);
  void begin(const Message& message);
  void add_column(const Message& message, std::string_view name, Kind kind);
  std::size_t column(const Message& message, std::string_view name, std::size_t expected) const;
  [[noreturn]] void fail(const Message& message, std::string_view what) const;
  [[noreturn]] void fail_without_rows() const;

  std::string topic_;
  Reader reader_;
  std::string chosen_;  ///< topic of the messages that are read
  bool begun_ = false;
  std::optional<Message> first_;  ///< first message: read, but not yet given as a row
  std::uint64_t messages_ = 0;
  TraceColumns columns_;
  std::unordered_map<std::string, std::size_t> positions_;
  std::vector<std::string> fields_;
  /// For each column, the number of the last message that had a value for it.
  std::vector<std::uint64_t> given_;
};

/// Gives the rows as CSV text in pieces of any size, each row with its line end.
class CsvOfRows {
 public:
  explicit CsvOfRows(Reader::Source source, std::string topic = "")
      : rows_(std::move(source), std::move(topic)) {}

  /// Returns the number of bytes; 0 at the end.
  std::size_t read(char* to, std::size_t size);
  const std::string& cut_off() const { return rows_.cut_off(); }

 private:
  RowsReader rows_;
  bool has_header_ = false;
  std::string text_;
  std::size_t given_ = 0;
};

}  // namespace smaservo::hal::mcap
