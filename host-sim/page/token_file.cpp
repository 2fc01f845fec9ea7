#include "host-sim/page/token_file.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <fmt/format.h>
#include <optional>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

#include "model/files/error.hpp"
#include "model/files/message.hpp"
#include "model/files/output_file.hpp"

namespace smaservo::page {
namespace {

constexpr std::size_t shortest = 32, longest = 256;

[[noreturn]] void fail(const std::string& path, std::string_view what) {
  throw files::UserError(fmt::format("token file {}: {}", files::printable(path), what));
}

[[noreturn]] void fail_by_errno(const std::string& path) {
  fail(path, std::strerror(errno));
}

class File {
 public:
  explicit File(int descriptor) : descriptor_(descriptor) {}
  ~File() {
    if (descriptor_ >= 0) {
      close(descriptor_);
    }
  }
  File(const File&) = delete;
  File& operator=(const File&) = delete;
  int get() const { return descriptor_; }

 private:
  int descriptor_;
};

std::string checked(const std::string& path, std::string token) {
  while (!token.empty() && (token.back() == '\n' || token.back() == '\r')) {
    token.pop_back();
  }
  const bool plain = std::ranges::all_of(token, [](char c) {
    return ('0' <= c && c <= '9') || ('a' <= c && c <= 'z') || ('A' <= c && c <= 'Z') || c == '-' ||
           c == '_';
  });
  if (token.size() < shortest || token.size() > longest || !plain) {
    fail(path,
         fmt::format("must have one line of {} to {} letters, digits, - and _; delete it, and "
                     "a new one will be made",
                     shortest, longest));
  }
  return token;
}

/// The content of the file; none if it does not exist.
std::optional<std::string> read_token(const std::string& path) {
  const File file(open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK));
  if (file.get() < 0) {
    if (errno == ENOENT) {
      return std::nullopt;
    }
    fail_by_errno(path);
  }
  struct stat status{};
  if (fstat(file.get(), &status) != 0) {
    fail_by_errno(path);
  }
  if (!S_ISREG(status.st_mode)) {
    fail(path, "is no file");
  }
  if ((status.st_mode & 0077U) != 0) {
    fail(path, "others may read or change it: delete it, and a new one will be made (mode 0600)");
  }
  if (status.st_uid != geteuid()) {
    fail(path, "belongs to another user");
  }
  std::array<char, longest + 3> bytes{};
  const ssize_t length = read(file.get(), bytes.data(), bytes.size());
  if (length < 0) {
    fail_by_errno(path);
  }
  return checked(path, {bytes.data(), static_cast<std::size_t>(length)});
}

/// Writes the token to another file and links it to its name: so two servers started at the same
/// time read the same token.
void make_token(const std::string& path) {
  const std::filesystem::path folder = std::filesystem::path(path).parent_path();
  if (std::error_code error; !folder.empty()) {
    std::filesystem::create_directories(folder, error);
    if (error) {
      fail(path, error.message());
    }
  }
  std::string beside = path + ".XXXXXX";
  const File file(mkostemp(beside.data(), O_CLOEXEC));
  if (file.get() < 0) {
    fail_by_errno(path);
  }
  const std::string line = random_token() + "\n";
  const bool written =
      write(file.get(), line.data(), line.size()) == static_cast<ssize_t>(line.size()) &&
      fsync(file.get()) == 0;
  const bool linked = written && (link(beside.c_str(), path.c_str()) == 0 || errno == EEXIST);
  const int error = errno;
  unlink(beside.c_str());
  errno = error;
  if (!linked || !files::sync_folder_of(path)) {
    fail_by_errno(path);
  }
}

const char* variable(const char* name) {
  const char* value = std::getenv(name);  // NOLINT(concurrency-mt-unsafe): before any thread
  return value != nullptr && *value == '/' ? value : nullptr;
}

}  // namespace

std::string random_token() {
  std::array<unsigned char, 32> bytes{};
  if (getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size())) {
    throw files::UserError(fmt::format("no random numbers: {}", std::strerror(errno)));
  }
  std::string text;
  for (const unsigned char byte : bytes) {
    text += fmt::format("{:02x}", byte);
  }
  return text;
}

std::string token_of(const std::string& path) {
  if (const auto token = read_token(path)) {
    return *token;
  }
  make_token(path);
  if (const auto token = read_token(path)) {
    return *token;
  }
  fail(path, "has gone");
}

std::string default_token_file() {
  if (const char* folder = variable("STATE_DIRECTORY")) {
    return std::string(folder) + "/page-token";
  }
  if (const char* folder = variable("XDG_STATE_HOME")) {
    return std::string(folder) + "/smaservo/page-token";
  }
  if (const char* folder = variable("HOME")) {
    return std::string(folder) + "/.local/state/smaservo/page-token";
  }
  throw files::ConfigError("--token-file: is needed where HOME is not set");
}

}  // namespace smaservo::page
