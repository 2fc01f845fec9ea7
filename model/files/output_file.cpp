#include "model/files/output_file.hpp"

#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>
#include <utility>

#include "model/files/error.hpp"

namespace smaservo::files {

namespace fs = std::filesystem;

namespace {

/// Whether the open file is still the one that has this name.
bool is_named(int file, const std::string& path) {
  struct stat open_one{};
  struct stat named{};
  return fstat(file, &open_one) == 0 && lstat(path.c_str(), &named) == 0 &&
         open_one.st_dev == named.st_dev && open_one.st_ino == named.st_ino;
}

/// Removes the partial file of a program that was killed while it wrote. False if another program
/// is writing it now and holds its lock.
bool remove_left_over(const std::string& beside) {
  // A link or a pipe cannot be a partial file: it is removed without being opened.
  const int file = open(beside.c_str(), O_WRONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
  const bool taken = file >= 0 && flock(file, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK;
  const bool removed = !taken && (file < 0 || is_named(file, beside)) &&
                       (unlink(beside.c_str()) == 0 || errno == ENOENT);
  const int why = taken ? EWOULDBLOCK : errno;
  if (file >= 0) {
    close(file);
  }
  errno = why;
  return removed;
}

/// Creates and locks a new file. Its name contains the process number, but every program in a
/// container may be number 1: therefore an existing file of that name is examined first.
int create_locked(const std::string& beside) {
  for (int tries = 0; tries < 10; ++tries) {
    const int file = open(beside.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (file < 0) {
      if (errno != EEXIST || (!remove_left_over(beside) && errno == EWOULDBLOCK)) {
        return -1;
      }
      continue;
    }
    // If the file system has no locks, the process number must be enough.
    const bool mine = flock(file, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK;
    if (mine && is_named(file, beside)) {
      return file;
    }
    close(file);
    errno = EWOULDBLOCK;
  }
  return -1;
}

}  // namespace

OutputFile::OutputFile(std::string path) : path_(std::move(path)) {
  if (path_ == "-") {
    file_ = stdout;
    return;
  }
  std::error_code ignored;
  if (fs::exists(path_, ignored) && !fs::is_regular_file(path_, ignored)) {
    // A device or a pipe is written directly, since it cannot be replaced.
    file_ = std::fopen(path_.c_str(), "wb");
    if (file_ == nullptr) {
      fail("cannot be written");
    }
    return;
  }
  // If the path is a link, the file that it points to is replaced, not the link.
  target_ = fs::is_symlink(path_, ignored) ? fs::weakly_canonical(path_).string() : path_;
  const std::string beside = fmt::format("{}.{}.part", target_, getpid());
  const int file = create_locked(beside);
  if (file < 0 && errno == EWOULDBLOCK) {
    throw UserError(fmt::format("{}: cannot be written: is being written at the same time", path_));
  }
  if (file < 0) {
    fail("cannot be written");
  }
  beside_ = beside;
  file_ = fdopen(file, "wb");
  if (file_ == nullptr) {
    const int why = errno;
    close(file);
    std::remove(beside_.c_str());
    errno = why;
    fail("cannot be written");
  }
}

OutputFile::~OutputFile() {
  // The file is removed before closing ends the lock: afterwards the name may belong to another
  // writer.
  if (!beside_.empty()) {
    std::remove(beside_.c_str());
  }
  if (file_ != nullptr && file_ != stdout) {
    std::fclose(file_);
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
  // The file is renamed before it is closed, since closing ends the lock; all data are written
  // already.
  if (std::rename(beside_.c_str(), target_.c_str()) != 0) {
    fail("cannot be written");
  }
  beside_.clear();
  std::fclose(std::exchange(file_, nullptr));
  if (!sync_folder_of(target_)) {
    fail("is written, but a loss of power may take it back");
  }
}

void OutputFile::fail(const char* what) const {
  throw UserError(fmt::format("{}: {}: {}", path_, what, std::strerror(errno)));
}

bool sync_folder_of(const std::string& path) {
  const std::string parent = fs::path(path).parent_path().string();
  const int folder =
      open(parent.empty() ? "." : parent.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (folder < 0) {
    return false;
  }
  // EINVAL: the file system either makes names durable by itself or cannot do so.
  const bool synced = fsync(folder) == 0 || errno == EINVAL;
  const int why = errno;
  close(folder);
  errno = why;
  return synced;
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
