#include "host-sim/output_file.hpp"

#include <cerrno>
#include <cstring>
#include <fmt/format.h>
#include <unistd.h>
#include <utility>

namespace smaservo {

OutputFile::OutputFile(std::string path) : path_(std::move(path)) {
  if (path_ == "-") {
    file_ = stdout;
    return;
  }
  beside_ = fmt::format("{}.{}.part", path_, getpid());
  file_ = std::fopen(beside_.c_str(), "wbx");
  if (file_ == nullptr) {
    fail("cannot be written");
  }
}

OutputFile::~OutputFile() {
  if (!beside_.empty()) {
    if (file_ != nullptr) {
      std::fclose(file_);
    }
    std::remove(beside_.c_str());
  }
}

void OutputFile::write(std::string_view text) {
  if (std::fwrite(text.data(), 1, text.size(), file_) != text.size()) {
    fail("cannot be written");
  }
}

void OutputFile::commit() {
  if (std::fflush(file_) != 0 || (!beside_.empty() && fsync(fileno(file_)) != 0)) {
    fail("cannot be written");
  }
  if (beside_.empty()) {
    return;
  }
  const int closed = std::fclose(std::exchange(file_, nullptr));
  if (closed != 0 || std::rename(beside_.c_str(), path_.c_str()) != 0) {
    fail("cannot be written");
  }
  beside_.clear();
}

void OutputFile::fail(const char* what) const {
  throw UserError(fmt::format("{}: {}: {}", path_, what, std::strerror(errno)));
}

}  // namespace smaservo
