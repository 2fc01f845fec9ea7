#include "model/files/output_file.hpp"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fmt/format.h>
#include <unistd.h>
#include <utility>

#include "model/files/error.hpp"

namespace smaservo::files {

namespace fs = std::filesystem;

OutputFile::OutputFile(std::string path) : path_(std::move(path)) {
  if (path_ == "-") {
    file_ = stdout;
    return;
  }
  std::error_code ignored;
  if (fs::exists(path_, ignored) && !fs::is_regular_file(path_, ignored)) {
    // A device or a pipe has nothing to be replaced.
    file_ = std::fopen(path_.c_str(), "wb");
    if (file_ == nullptr) {
      fail("cannot be written");
    }
    return;
  }
  // What a link points to is replaced, not the link.
  target_ = fs::is_symlink(path_, ignored) ? fs::weakly_canonical(path_).string() : path_;
  beside_ = fmt::format("{}.{}.part", target_, getpid());
  file_ = std::fopen(beside_.c_str(), "wbx");
  if (file_ == nullptr) {
    fail("cannot be written");
  }
}

OutputFile::~OutputFile() {
  if (file_ != nullptr && file_ != stdout) {
    std::fclose(file_);
  }
  if (!beside_.empty()) {
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
  if (closed != 0 || std::rename(beside_.c_str(), target_.c_str()) != 0) {
    fail("cannot be written");
  }
  beside_.clear();
}

void OutputFile::fail(const char* what) const {
  throw UserError(fmt::format("{}: {}: {}", path_, what, std::strerror(errno)));
}

void prepare_folder(const char* option, const std::string& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (!std::filesystem::is_directory(folder) || access(folder.c_str(), W_OK) != 0) {
    throw UserError(
        fmt::format("{} {}: {}", option, folder, error ? error.message() : std::strerror(errno)));
  }
}

}  // namespace smaservo::files
