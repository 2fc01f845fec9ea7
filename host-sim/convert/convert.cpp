#include "host-sim/convert/convert.hpp"

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <functional>
#include <memory>
#include <optional>
#include <sys/stat.h>
#include <utility>
#include <vector>

#include "hal/recording/mcap/rows_reader.hpp"
#include "hal/recording/mcap/rows_writer.hpp"
#include "hal/recording/trace_file.hpp"
#include "host-sim/convert/own_rows.hpp"
#include "host-sim/how_read.hpp"
#include "model/files/error.hpp"
#include "model/files/output_file.hpp"
#include "model/units.hpp"

namespace smaservo::convert {
namespace {

using files::UserError;
namespace mcap = hal::mcap;

constexpr std::size_t block = std::size_t{1} << 16U;

/// The input file, read from its beginning.
class Input {
 public:
  explicit Input(const std::string& path)
      : file_(path == "-" ? stdin : std::fopen(path.c_str(), "rb"), &close) {
    struct stat status{};
    if (!file_ || fstat(fileno(file_.get()), &status) != 0) {
      throw UserError(std::strerror(errno));
    }
    if (S_ISDIR(status.st_mode)) {
      throw UserError("is a folder, not a trace");
    }
    rewinds_ = S_ISREG(status.st_mode) && std::ftell(file_.get()) == 0;
    head_.resize(mcap::magic.size());
    head_.resize(std::fread(head_.data(), 1, head_.size(), file_.get()));
    is_mcap_ = head_ == mcap::magic;
  }

  bool is_mcap() const { return is_mcap_; }
  /// Whether the input can be read twice.
  bool rewinds() const { return rewinds_; }
  void rewind() {
    if (std::fseek(file_.get(), 0, SEEK_SET) != 0) {
      throw UserError(std::strerror(errno));
    }
    head_.clear();
  }
  /// Returns the number of bytes; 0 at the end.
  std::size_t read(char* to, std::size_t size) {
    const std::size_t part = head_.copy(to, size);
    head_.erase(0, part);
    const std::size_t got = part + std::fread(to + part, 1, size - part, file_.get());
    if (std::ferror(file_.get()) != 0) {
      throw UserError(std::strerror(errno));
    }
    return got;
  }

 private:
  static void close(std::FILE* file) {
    if (file != nullptr && file != stdin) {
      std::fclose(file);
    }
  }

  std::unique_ptr<std::FILE, void (*)(std::FILE*)> file_;
  bool rewinds_ = false, is_mcap_ = false;
  std::string head_;
};

/// Writes an MCAP file from CSV text.
class McapSink {
 public:
  McapSink(const ConvertOptions& options, const std::string& source, files::OutputFile& file,
           std::vector<mcap::Kind> kinds)
      : rows_({"host-sim convert", source}, std::move(kinds), options.compressed), file_(file) {}

  void write(std::string_view csv) {
    rows_.add(csv);
    file_.write(rows_.take());
  }
  Converted commit() {
    rows_.finish();
    if (rows_.rows() == 0) {
      throw UserError("has a header and no row");
    }
    if (std::ranges::none_of(rows_.columns(), [](const auto& column) {
          return column.kind == mcap::Kind::number;
        })) {
      throw UserError("no column has numbers; a trace is a table of them");
    }
    file_.write(rows_.take());
    file_.commit();
    return {rows_.rows(), rows_.columns().size(), "", rows_.remarks()};
  }

 private:
  mcap::RowsWriter rows_;
  files::OutputFile& file_;
};

/// Calls `take` with the pieces of a text, which an Input or OwnRows gives.
template <class Text>
void each_piece(Text& input, const std::function<void(std::string_view)>& take) {
  std::vector<char> buffer(block);
  for (std::size_t got = 0; (got = input.read(buffer.data(), buffer.size())) > 0;) {
    take({buffer.data(), got});
  }
}

/// The columns of a file, with the counts of their values in all rows.
struct SurveyedColumns {
  std::vector<std::string> names;
  std::vector<mcap::FieldCounts> counts;

  std::vector<mcap::Kind> kinds() const {
    std::vector<mcap::Kind> all;
    for (const mcap::FieldCounts& column : counts) {
      // A column without values is a text: most such columns are faults that did not happen.
      const mcap::Kind kind = column.kind();
      all.push_back(kind == mcap::Kind::unknown ? mcap::Kind::text : kind);
    }
    return all;
  }
  /// Remarks on the columns that contain numbers but are texts.
  std::vector<std::string> remarks() const {
    std::vector<std::string> all;
    for (std::size_t i = 0; i < counts.size(); ++i) {
      const mcap::FieldCounts& c = counts[i];
      if (c.numbers > 0 && c.kind() == mcap::Kind::text) {
        all.push_back(fmt::format(
            "line {}, column {} ({}): '{}': a column of texts, for {} of its "
            "{} values are no numbers",
            c.first_text_line, i + 1, names[i], c.first_text, c.texts, c.texts + c.numbers));
      }
    }
    return all;
  }
};

template <class Text>
SurveyedColumns survey(Text& input) {
  constexpr std::size_t longest_line = std::size_t{1} << 20U;  // a longer line will be refused
  std::string rest, header;
  SurveyedColumns found;
  std::vector<std::string_view> fields;
  std::uint64_t lines = 0;
  each_piece(input, [&](std::string_view piece) {
    if (rest.size() > longest_line) {
      return;
    }
    rest += piece;
    std::size_t from = 0;
    for (std::size_t end = 0; (end = rest.find('\n', from)) != std::string::npos; from = end + 1) {
      std::string_view line = std::string_view(rest).substr(from, end - from);
      line.remove_suffix(line.ends_with('\r') ? 1 : 0);
      ++lines;
      if (found.names.empty()) {
        line.remove_prefix(line.starts_with("\xEF\xBB\xBF") ? 3 : 0);
        header = line;
        found.names = mcap::header_names(line);
        found.counts.resize(found.names.size());
      } else if (line != header && mcap::split_row(line, found.names.size(), fields)) {
        for (std::size_t i = 0; i < fields.size(); ++i) {
          found.counts[i].add(fields[i], lines);
        }
      }
    }
    rest.erase(0, from);
  });
  return found;
}

/// Refuses a file whose columns are separated by another character, and a file whose times are in a
/// column that is not understood: each row would otherwise last 1 ms.
void check_header(const std::vector<std::string>& names) {
  const std::size_t other = names.size() == 1 ? names[0].find_first_of(";\t|") : std::string::npos;
  if (other != std::string::npos) {
    throw UserError(fmt::format(
        "line 1: one column, '{}'; columns must be separated by commas, not "
        "by {}",
        names[0], names[0][other] == '\t' ? "tabs" : "'" + names[0].substr(other, 1) + "'"));
  }
  std::vector<std::string> times;
  for (const std::string& name : names) {
    if (unit_of(name, "time", kind::time)) {
      return;
    }
    std::string lower = name;
    std::ranges::transform(lower, lower.begin(), [](unsigned char c) { return std::tolower(c); });
    if (lower == "t" || lower.starts_with("time") || lower.starts_with("date")) {
      times.push_back(name);
    }
  }
  if (!times.empty()) {
    throw UserError(
        fmt::format("line 1: {}: is no column of time that is understood, which is "
                    "time_s, time_ms or time_us and holds numbers; change the name",
                    fmt::join(times, ", ")));
  }
}

Converted from_csv(const ConvertOptions& options, const std::string& source, Input& input,
                   files::OutputFile& file) {
  if (!hal::is_mcap_name(options.out)) {
    throw UserError(fmt::format(
        "is CSV, and so would be {}: the name of an MCAP file ends in .mcap", options.out));
  }
  SurveyedColumns columns;
  if (input.rewinds()) {
    columns = survey(input);
    check_header(columns.names);
    input.rewind();
  }
  McapSink sink(options, source, file, columns.kinds());
  each_piece(input, [&](std::string_view piece) { sink.write(piece); });
  Converted result = sink.commit();
  const std::vector<std::string> texts = columns.remarks();
  result.remarks.insert(result.remarks.end(), texts.begin(), texts.end());
  return result;
}

/// Another program's table: its rows in this project's dialect.
Converted from_foreign(const ConvertOptions& options, const std::string& source,
                       files::OutputFile& file) {
  OwnRows rows(options.in, options.renames);
  say_how_read(options.in, rows.trace());
  Converted result;
  if (hal::is_mcap_name(options.out)) {
    OwnRows surveyed(options.in, options.renames);
    const SurveyedColumns columns = survey(surveyed);
    check_header(columns.names);
    McapSink sink(options, source, file, columns.kinds());
    each_piece(rows, [&](std::string_view piece) { sink.write(piece); });
    result = sink.commit();
    const std::vector<std::string> texts = columns.remarks();
    result.remarks.insert(result.remarks.end(), texts.begin(), texts.end());
  } else {
    each_piece(rows, [&](std::string_view piece) { file.write(piece); });
    file.commit();
    result = {rows.trace().rows(), rows.trace().names().size(), "", {}};
  }
  say_what_was_skipped(options.in, rows.trace());
  const std::vector<std::string>& complaints = rows.trace().complaints();
  result.remarks.insert(result.remarks.end(), complaints.begin(), complaints.end());
  return result;
}

/// Whether a file is a table that this project did not write. One that no trace can be read from is
/// left to the conversion of CSV, whose messages say more of it.
bool is_foreign(const ConvertOptions& options) {
  try {
    return OwnRows(options.in, options.renames).is_foreign();
  } catch (const files::Error&) {
    if (!options.renames.empty()) {
      throw;
    }
    return false;
  }
}

Converted from_mcap(const ConvertOptions& options, const std::string& source, Input& input,
                    files::OutputFile& file) {
  mcap::RowsReader rows([&](char* to, std::size_t size) { return input.read(to, size); },
                        options.topic);
  std::vector<mcap::Kind> kinds;
  for (const mcap::TraceColumn& column : rows.columns()) {
    kinds.push_back(column.kind);
  }
  std::optional<McapSink> sink;
  if (hal::is_mcap_name(options.out)) {
    sink.emplace(options, source, file, kinds);
  }
  Converted result;
  result.columns = kinds.size();
  std::string text = rows.header() + '\n';
  do {
    if (sink) {
      sink->write(text);
    } else {
      file.write(text);
    }
    text.clear();
    while (text.size() < block && rows.next(text)) {
      text += '\n';
      ++result.rows;
    }
  } while (!text.empty());
  if (sink) {
    result = sink->commit();
  } else {
    file.commit();
  }
  result.cut_off = rows.cut_off();
  return result;
}

}  // namespace

Converted convert(const ConvertOptions& options) {
  const std::string source = options.in == "-" ? "standard input" : options.in;
  files::OutputFile file(options.out);
  try {
    Input input(options.in);
    if (!input.is_mcap() && hal::is_mcap_name(options.in)) {
      throw mcap::Malformed(0, "is no MCAP file: must begin with 89 4D 43 41 50 30 0D 0A");
    }
    if (!input.is_mcap() && input.rewinds() && is_foreign(options)) {
      return from_foreign(options, source, file);
    }
    return input.is_mcap() ? from_mcap(options, source, input, file)
                           : from_csv(options, source, input, file);
  } catch (const UserError& problem) {
    throw UserError(fmt::format("{}: {}", source, problem.what()));
  }
}

}  // namespace smaservo::convert
