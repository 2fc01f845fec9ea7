#pragma once
// Tables that other programs write, as the reader's own dialect: one line out for each line in, so
// that messages can name the file's line.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "hal/replay/sheet/layout.hpp"
#include "hal/replay/sheet/pyris.hpp"

namespace smaservo::hal {

/// UTF-16 as UTF-8, where the text begins with the mark of its order; anything else unchanged,
/// without the mark of UTF-8.
class Utf8Text {
 public:
  using Read = std::function<std::size_t(char* to, std::size_t room)>;
  explicit Utf8Text(Read read) : read_(std::move(read)) {}

  /// Appends some of the text; false at the end.
  bool more(std::string& text);
  /// "UTF-16"; empty where nothing was changed.
  std::string_view encoding() const { return width_ == 2 ? "UTF-16" : ""; }

 private:
  void take_mark();
  void decode(std::string& text);

  Read read_;
  std::unique_ptr<char[]> block_;  ///< not set to zero: most files fill a small part of it
  std::string bytes_;              ///< read, and not decoded yet
  int width_ = 0;                  ///< bytes of a unit of the text; 0: nothing has been read
  bool big_ = false;               ///< the high byte comes first
  std::uint32_t high_ = 0;         ///< first half of a character in two units
};

class CsvOfSheet {
 public:
  /// `read` gives the bytes of the file, of which as many are taken as tell the layout: the first
  /// line where `is_own_header(line)` holds, 64 kB otherwise. Without that function every table is
  /// foreign. Throws UserError for an export of Pyris that lacks something (pyris.hpp).
  CsvOfSheet(Utf8Text::Read read, bool (*is_own_header)(std::string_view line));

  /// Whether the text is a table that the reader would not understand as it is.
  bool is_foreign() const { return foreign_; }
  /// The text as it is, from its beginning, where it is not foreign; without the mark of its order.
  std::size_t read_raw(char* to, std::size_t room);
  /// The table as comma-separated text with a header. Returns the number of bytes; 0 at the end.
  std::size_t read(char* to, std::size_t room);
  /// The number of the file's line in which a line of the output stands.
  std::uint64_t line_of(std::uint64_t line) const { return line + header_lines_ - 1; }
  /// Of a table that is foreign.
  const SheetLayout& layout() const { return layout_; }
  /// "separated by semicolons, decimal comma, names in line 23, UTF-16".
  std::string said() const;
  std::uint64_t repeated() const { return repeated_; }  ///< headers in the middle, skipped
  /// Lines among the rows that are none, as the messages of a microcontroller; they are skipped.
  std::uint64_t strays() const { return strays_; }
  /// The first of them: "line 17: 'ets Jun  8 2016'"; empty: there are none.
  const std::string& first_stray() const { return first_stray_; }

 private:
  bool next_line(std::string_view& line, bool& complete);
  void translate(std::string_view line, bool complete);
  bool begin_pyris(const std::vector<std::string_view>& lines);
  void skip_lines_above();
  void skip_stray(std::string_view line);
  void name_clock(std::string_view row);
  void write(const std::vector<std::string>& fields);

  Utf8Text text_;
  std::string in_;         ///< text that has not been taken
  std::size_t taken_ = 0;  ///< of in_
  bool ended_ = false;
  bool foreign_ = false;
  std::optional<PyrisExport> pyris_;
  SheetLayout layout_;
  std::uint64_t header_lines_ = 1;  ///< lines of the file up to the one that the header stands for
  std::string header_;              ///< as in the file
  std::uint64_t repeated_ = 0, strays_ = 0, lines_ = 0;  ///< lines_: translated
  std::string first_stray_;
  bool latin_ = false;  ///< the names are in Latin-1
  std::string out_;
  std::size_t given_ = 0;  ///< of out_
  std::vector<std::string> fields_;
};

}  // namespace smaservo::hal
