#include "hal/replay/trace_text.hpp"

#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include "hal/recording/trace_file.hpp"
#include "hal/replay/trace_columns.hpp"
#include "model/files/error.hpp"

namespace smaservo::hal {

TraceText::TraceText(const std::string& path) {
  open_file(path);
  try {
    content_ = std::make_unique<Unpacked>(
        [this](char* to, std::size_t room) { return read_file(to, room); });
    const auto read_on = [this](char* to, std::size_t room) { return content_->read(to, room); };
    if (ForeignTable::begins(content_->head())) {
      open_foreign();
    } else if (content_->head().starts_with(mcap::magic) || is_mcap_name(path)) {
      mcap_ = std::make_unique<mcap::CsvOfRows>(read_on);
    } else {
      sheet_ = std::make_unique<CsvOfSheet>(read_on, TraceColumns::is_own_header);
    }
  } catch (...) {
    if (file_ > STDIN_FILENO) {
      close(file_);
    }
    throw;
  }
}

TraceText::~TraceText() {
  if (file_ > STDIN_FILENO) {
    close(file_);
  }
}

void TraceText::open_foreign() {
  // Its beginning is not where a reader of such a file begins, so a pipe will not do.
  struct stat status{};
  if (content_->is_packed() || fstat(file_, &status) != 0 || !S_ISREG(status.st_mode)) {
    throw files::UserError(
        content_->is_packed()
            ? "is a spreadsheet or MATLAB file that was compressed once more; unpack it first"
            : "is a spreadsheet or MATLAB file, which cannot be read from a pipe; save it as a "
              "file first");
  }
  table_ = std::make_unique<ForeignTable>(file_);
  sheet_ = std::make_unique<CsvOfSheet>(
      [this](char* to, std::size_t room) { return read_foreign(to, room); }, nullptr);
}

std::size_t TraceText::read_foreign(char* to, std::size_t room) {
  const std::size_t got = table_->read(to, room);
  bytes_ = got == 0 ? size_ : bytes_;
  return got;
}

void TraceText::open_file(const std::string& path) {
  if (path == "-") {
    file_ = STDIN_FILENO;
    return;
  }
  file_ = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file_ < 0) {
    throw files::UserError(std::strerror(errno));
  }
  struct stat status{};
  if (fstat(file_, &status) == 0 && S_ISREG(status.st_mode)) {
    size_ = static_cast<std::uint64_t>(status.st_size);
  }
  if (S_ISDIR(status.st_mode)) {
    close(file_);
    throw files::UserError("is a folder, not a trace");
  }
}

std::size_t TraceText::read_file(char* to, std::size_t room) {
  ssize_t got = 0;
  do {
    got = ::read(file_, to, room);
  } while (got < 0 && errno == EINTR);
  if (got < 0) {
    throw files::UserError(std::strerror(errno));
  }
  bytes_ += static_cast<std::uint64_t>(got);
  return static_cast<std::size_t>(got);
}

std::size_t TraceText::read(char* to, std::size_t room) {
  return mcap_                  ? mcap_->read(to, room)
         : sheet_->is_foreign() ? sheet_->read(to, room)
                                : sheet_->read_raw(to, room);
}

std::string TraceText::layout() const {
  if (!sheet_ || !sheet_->is_foreign()) {
    return table_ ? table_->description() : "";
  }
  if (!table_) {
    return sheet_->said();
  }
  const std::size_t header = sheet_->layout().header;
  return table_->description() + (header == 0          ? ", no names"
                                  : table_->is_sheet() ? fmt::format(", names in row {}", header)
                                                       : "");
}

std::string_view TraceText::word() const {
  return mcap_ ? "message" : table_ ? "row" : "line";
}

std::uint64_t TraceText::number(std::uint64_t line) const {
  if (mcap_ || (table_ && !table_->is_sheet())) {
    return line - 1;
  }
  return sheet_->is_foreign() ? sheet_->line_of(line) : line;
}

std::string TraceText::place(std::uint64_t line) const {
  const bool of_names = line == 1 && (mcap_ || (table_ && !table_->is_sheet()));
  return of_names ? (mcap_ ? "schema" : "names") : fmt::format("{} {}", word(), number(line));
}

}  // namespace smaservo::hal
