#include "host-sim/convert/convert.hpp"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fmt/format.h>
#include <functional>
#include <memory>
#include <sys/stat.h>
#include <utility>
#include <vector>

#include "model/files/error.hpp"
#include "model/files/mcap/rows_reader.hpp"
#include "model/files/mcap/rows_writer.hpp"
#include "model/files/output_file.hpp"
#include "model/files/trace_file.hpp"

namespace smaservo::convert {
namespace {

using files::UserError;
namespace mcap = files::mcap;

constexpr std::size_t block = std::size_t{1} << 16U;

/// The file that is read, from its beginning.
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
  /// Whether it can be read twice.
  bool rewinds() const { return rewinds_; }
  void rewind() {
    if (std::fseek(file_.get(), 0, SEEK_SET) != 0) {
      throw UserError(std::strerror(errno));
    }
    head_.clear();
  }
  /// 0 at the end.
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

/// What is written, as CSV text goes in. Lines are checked and counted on the way.
class Sink {
 public:
  Sink(const ConvertOptions& options, const std::string& source, files::OutputFile& file,
       std::vector<mcap::Kind> kinds)
      : to_mcap_(files::is_mcap_name(options.out)),
        rows_({"host-sim convert", source}, std::move(kinds), to_mcap_ && options.compressed),
        file_(file) {}

  void write(std::string_view csv) {
    rows_.add(csv);
    const std::string made = rows_.take();
    file_.write(to_mcap_ ? std::string_view(made) : csv);
  }
  Converted commit() {
    rows_.finish();
    const std::string made = rows_.take();
    file_.write(to_mcap_ ? std::string_view(made) : "");
    file_.commit();
    return {rows_.rows(), rows_.columns().size(), ""};
  }

 private:
  bool to_mcap_;
  mcap::RowsWriter rows_;
  files::OutputFile& file_;
};

/// Calls `take` with the pieces of the file's text.
void each_piece(Input& input, const std::function<void(std::string_view)>& take) {
  std::vector<char> buffer(block);
  for (std::size_t got = 0; (got = input.read(buffer.data(), buffer.size())) > 0;) {
    take({buffer.data(), got});
  }
}

/// The kinds of the columns by all rows of the file.
std::vector<mcap::Kind> kinds_of(Input& input) {
  constexpr std::size_t longest_line = std::size_t{1} << 20U;  // a longer one will be refused
  std::string rest;
  mcap::TraceColumns columns;
  std::vector<std::string_view> fields;
  each_piece(input, [&](std::string_view piece) {
    if (rest.size() > longest_line) {
      return;
    }
    rest += piece;
    std::size_t from = 0;
    for (std::size_t end = 0; (end = rest.find('\n', from)) != std::string::npos; from = end + 1) {
      std::string_view line = std::string_view(rest).substr(from, end - from);
      line.remove_suffix(line.ends_with('\r') ? 1 : 0);
      if (columns.empty()) {
        columns.resize(mcap::header_names(line).size());
      } else if (mcap::split_row(line, columns.size(), fields)) {
        mcap::learn(columns, fields);
      }
    }
    rest.erase(0, from);
  });
  std::vector<mcap::Kind> kinds;
  for (const mcap::TraceColumn& column : columns) {
    // Without a value it is a text: most of these are faults that have not happened.
    kinds.push_back(column.kind == mcap::Kind::unknown ? mcap::Kind::text : column.kind);
  }
  return kinds;
}

Converted from_csv(const ConvertOptions& options, const std::string& source, Input& input,
                   files::OutputFile& file) {
  if (!files::is_mcap_name(options.out)) {
    throw UserError(fmt::format(
        "is CSV, and so would be {}: the name of an MCAP file ends in .mcap", options.out));
  }
  std::vector<mcap::Kind> kinds;
  if (input.rewinds()) {
    kinds = kinds_of(input);
    input.rewind();
  }
  Sink sink(options, source, file, std::move(kinds));
  each_piece(input, [&](std::string_view piece) { sink.write(piece); });
  return sink.commit();
}

Converted from_mcap(const ConvertOptions& options, const std::string& source, Input& input,
                    files::OutputFile& file) {
  mcap::RowsReader rows([&](char* to, std::size_t size) { return input.read(to, size); },
                        options.topic);
  std::vector<mcap::Kind> kinds;
  for (const mcap::TraceColumn& column : rows.columns()) {
    kinds.push_back(column.kind);
  }
  Sink sink(options, source, file, std::move(kinds));
  std::string text = rows.header() + '\n';
  do {
    sink.write(text);
    text.clear();
    while (text.size() < block && rows.next(text)) {
      text += '\n';
    }
  } while (!text.empty());
  Converted result = sink.commit();
  result.cut_off = rows.cut_off();
  return result;
}

}  // namespace

Converted convert(const ConvertOptions& options) {
  const std::string source = options.in == "-" ? "standard input" : options.in;
  files::OutputFile file(options.out);
  try {
    Input input(options.in);
    if (!input.is_mcap() && files::is_mcap_name(options.in)) {
      throw mcap::Malformed(0, "is no MCAP file: must begin with 89 4D 43 41 50 30 0D 0A");
    }
    return input.is_mcap() ? from_mcap(options, source, input, file)
                           : from_csv(options, source, input, file);
  } catch (const UserError& problem) {
    throw UserError(fmt::format("{}: {}", source, problem.what()));
  }
}

}  // namespace smaservo::convert
