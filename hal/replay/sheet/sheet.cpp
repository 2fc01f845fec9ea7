#include "hal/replay/sheet/sheet.hpp"

#include <algorithm>
#include <fmt/format.h>

#include "hal/recording/utf8.hpp"
#include "hal/replay/sheet/meaning.hpp"

namespace smaservo::hal {
namespace {

/// So much of the text is looked at for its layout.
constexpr std::size_t looked_at = std::size_t{1} << 16;
/// A socket of packets discards what does not fit.
constexpr std::size_t block = std::size_t{1} << 20;
constexpr std::size_t longest_line = std::size_t{1} << 20;

std::vector<std::string_view> lines_of(std::string_view text) {
  std::vector<std::string_view> lines;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string_view line = text.substr(0, end);
    line.remove_suffix(line.ends_with('\r') ? 1 : 0);
    lines.push_back(line);
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return lines;
}

std::string_view name_of(char separator) {
  return separator == ','    ? "commas"
         : separator == ';'  ? "semicolons"
         : separator == '\t' ? "tabs"
         : separator == '|'  ? "vertical bars"
                             : "blanks";
}

}  // namespace

bool Utf8Text::more(std::string& text) {
  if (!block_) {
    block_ = std::make_unique_for_overwrite<char[]>(block);
  }
  const std::size_t got = read_(block_.get(), block);
  bytes_.append(block_.get(), got);
  if (width_ == 0 && got > 0 && bytes_.size() < 3) {
    return true;
  }
  if (width_ == 0) {
    take_mark();
  }
  if (width_ == 1) {
    text += bytes_;
    bytes_.clear();
  } else {
    decode(text);
  }
  return got > 0;
}

void Utf8Text::take_mark() {
  const std::string_view mark(bytes_.data(), std::min<std::size_t>(bytes_.size(), 2));
  const bool little = mark == "\xFF\xFE";
  big_ = mark == "\xFE\xFF";
  width_ = little || big_ ? 2 : 1;
  bytes_.erase(0, width_ == 2 ? 2U : bytes_.starts_with("\xEF\xBB\xBF") ? 3U : 0U);
}

void Utf8Text::decode(std::string& text) {
  constexpr std::uint32_t unknown = 0xFFFD;
  std::size_t i = 0;
  for (; i + 1 < bytes_.size(); i += 2) {
    const auto first = static_cast<unsigned char>(bytes_[i]);
    const auto second = static_cast<unsigned char>(bytes_[i + 1]);
    const std::uint32_t unit =
        big_ ? std::uint32_t{first} << 8U | second : std::uint32_t{second} << 8U | first;
    const bool high = 0xD800 <= unit && unit < 0xDC00;
    const bool low = 0xDC00 <= unit && unit < 0xE000;
    if (low && high_ != 0) {
      put_utf8(text, 0x10000 + ((high_ - 0xD800) << 10U) + (unit - 0xDC00));
    } else if (!high) {
      put_utf8(text, low ? unknown : unit);
    }
    high_ = high ? unit : 0;
  }
  bytes_.erase(0, i);
}

CsvOfSheet::CsvOfSheet(Utf8Text::Read read, bool (*is_own_header)(std::string_view line))
    : text_(std::move(read)) {
  while (in_.size() < looked_at && text_.more(in_)) {
    const std::size_t end = in_.find('\n');
    std::string_view first = std::string_view(in_).substr(0, end);
    first.remove_suffix(first.ends_with('\r') ? 1 : 0);
    if (is_own_header != nullptr && end != std::string::npos && is_own_header(first)) {
      return;
    }
  }
  // A line that is not whole would not tell its number of fields.
  const std::string_view all(in_);
  const std::size_t end = all.size() < looked_at ? all.size() : all.rfind('\n');
  const auto lines = lines_of(all.substr(0, end));
  if (begin_pyris(lines)) {
    return;
  }
  const auto layout = find_layout(lines);
  foreign_ = layout.has_value();
  if (!foreign_) {
    return;
  }
  layout_ = *layout;
  for (std::string& name : layout_.names) {
    latin_ = latin_ || !is_utf8(name);
    name = utf8_of(name);
  }
  name_clock(lines[layout_.first - 1]);
  header_ = layout_.header == 0 ? "" : std::string(lines[layout_.header - 1]);
  skip_lines_above();
}

bool CsvOfSheet::begin_pyris(const std::vector<std::string_view>& lines) {
  pyris_ = PyrisExport::find(lines);
  if (pyris_) {
    foreign_ = true;
    layout_.first = pyris_->first();
    layout_.names = PyrisExport::names();
    layout_.columns = layout_.names.size();
    skip_lines_above();
  }
  return pyris_.has_value();
}

/// The names stand for all lines above the rows.
void CsvOfSheet::skip_lines_above() {
  header_lines_ = layout_.first - 1;
  for (std::size_t i = 1; i < layout_.first; ++i) {
    std::string_view line;
    bool complete = false;
    next_line(line, complete);
  }
  write(layout_.names);
}

std::size_t CsvOfSheet::read_raw(char* to, std::size_t room) {
  if (taken_ == in_.size()) {
    in_.clear();
    taken_ = 0;
    while (in_.empty() && text_.more(in_)) {
    }
  }
  const std::size_t part = in_.copy(to, room, taken_);
  taken_ += part;
  return part;
}

bool CsvOfSheet::next_line(std::string_view& line, bool& complete) {
  std::size_t end = in_.find('\n', taken_);
  // A line that is longer than the reader takes is passed on in parts.
  while (end == std::string::npos && !ended_ && in_.size() - taken_ < longest_line) {
    in_.erase(0, taken_);
    taken_ = 0;
    const std::size_t searched = in_.size();
    ended_ = !text_.more(in_);
    end = in_.find('\n', searched);
  }
  complete = end != std::string::npos;
  if (!complete && taken_ == in_.size()) {
    return false;
  }
  const std::size_t stop = complete ? end : in_.size();
  line = std::string_view(in_).substr(taken_, stop - taken_);
  line.remove_suffix(line.ends_with('\r') ? 1 : 0);
  taken_ = complete ? stop + 1 : stop;
  return true;
}

std::size_t CsvOfSheet::read(char* to, std::size_t room) {
  std::string_view line;
  bool complete = false;
  while (given_ == out_.size()) {
    out_.clear();
    given_ = 0;
    if (!next_line(line, complete)) {
      return 0;
    }
    translate(line, complete);
  }
  const std::size_t part = out_.copy(to, room, given_);
  given_ += part;
  return part;
}

/// A column of the time whose rows are clocks needs no unit in its name.
void CsvOfSheet::name_clock(std::string_view row) {
  split_sheet_line(row, layout_.separator, fields_);
  for (std::size_t i = 0; i < std::min(fields_.size(), layout_.names.size()); ++i) {
    const auto meaning = meaning_of(layout_.names[i]);
    if (meaning && meaning->base == "time" && meaning->unit.empty() &&
        fields_[i].find(':') != std::string::npos &&
        plain_number(fields_[i], layout_.decimal).has_value()) {
      layout_.names[i] += " [s]";
    }
  }
}

void CsvOfSheet::skip_stray(std::string_view line) {
  constexpr std::size_t shown = 40;
  if (++strays_ == 1) {
    first_stray_ = fmt::format("line {}: '{}'", header_lines_ + lines_,
                               utf8_of(line.substr(0, std::min(line.size(), shown))));
  }
  out_ = "\n";
}

/// Comments, headers in the middle and lines that are no rows become empty lines, which the reader
/// skips.
void CsvOfSheet::translate(std::string_view line, bool complete) {
  ++lines_;
  if (pyris_) {
    // Of a last line without an end nobody knows whether its numbers are whole.
    if (complete && pyris_->take(line, fields_)) {
      write(fields_);
    } else {
      out_ = "\n";
    }
    return;
  }
  const bool repeated = !header_.empty() && line == header_;
  repeated_ += repeated ? 1 : 0;
  if (repeated || line.empty() || line.starts_with('#') || line.starts_with('%')) {
    out_ = "\n";
    return;
  }
  split_sheet_line(line, layout_.separator, fields_);
  if (fields_.size() == layout_.columns + 1 && fields_.back().empty()) {
    fields_.pop_back();
  }
  if (complete && !is_sheet_row(fields_, layout_)) {
    skip_stray(line);
    return;
  }
  for (std::string& field : fields_) {
    if (const auto number = plain_number(field, layout_.decimal)) {
      field = *number;
    }
  }
  write(fields_);
  if (!complete) {
    out_.pop_back();
  }
}

void CsvOfSheet::write(const std::vector<std::string>& fields) {
  for (std::size_t i = 0; i < fields.size(); ++i) {
    out_ += i > 0 ? "," : "";
    // A comma within a text would end the field.
    const std::size_t from = out_.size();
    out_ += utf8_of(fields[i]);
    std::replace(out_.begin() + static_cast<std::ptrdiff_t>(from), out_.end(), ',', ';');
  }
  out_ += '\n';
}

std::string CsvOfSheet::said() const {
  if (pyris_) {
    return pyris_->said();
  }
  std::string said = fmt::format("separated by {}", name_of(layout_.separator));
  said += layout_.decimal == ',' ? ", decimal comma" : "";
  said += layout_.header == 0 ? ", no names" : fmt::format(", names in line {}", layout_.header);
  said += layout_.units == 0 ? "" : fmt::format(", units in line {}", layout_.units);
  said += text_.encoding().empty() ? "" : fmt::format(", {}", text_.encoding());
  said += latin_ ? ", Latin-1" : "";
  return said;
}

}  // namespace smaservo::hal
