#include "model/files/output_file.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <climits>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <fmt/format.h>
#include <functional>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>
#include <utility>

#include "model/files/error.hpp"

namespace smaservo::files {

namespace fs = std::filesystem;

namespace {

constexpr std::string_view partial_end = ".part";
constexpr std::chrono::hours left_over_age{1};

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

/// Creates and locks a new file. Its name contains host and process number, but every program in a
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

/// Of this computer; what a file's name cannot hold is replaced.
std::string host_name() {
  std::array<char, HOST_NAME_MAX + 1> name{};
  gethostname(name.data(), name.size() - 1);
  std::string host(name.data());
  std::ranges::replace(host, '/', '_');
  return host;
}

}  // namespace

std::string partial_path(const std::string& path, std::string host, long process) {
  const std::string end = fmt::format(".{}{}", process, partial_end);
  const std::size_t taken = fs::path(path).filename().string().size() + 1 + end.size();
  const std::size_t room = taken < NAME_MAX ? NAME_MAX - taken : 0;
  // Computers of one group differ in the first label of their names, and there mostly at its end.
  host.resize(std::min(host.size(), host.find('.')));
  host.erase(0, host.size() - std::min(host.size(), room));
  return host.empty() ? path + end : fmt::format("{}.{}{}", path, host, end);
}

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
  const std::string beside = partial_path(target_, host_name(), getpid());
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

void remove_left_overs(const std::string& folder,
                       const std::function<bool(const std::string& name)>& wanted) {
  std::error_code ignored;
  const auto now = fs::file_time_type::clock::now();
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, ignored)) {
    const std::string name = entry.path().filename().string();
    if (!name.ends_with(partial_end) || !wanted(name)) {
      continue;
    }
    const fs::file_time_type written = entry.last_write_time(ignored);
    if (!ignored && written < now - left_over_age) {
      remove_left_over(entry.path().string());
    }
  }
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
