#include "hal/linux/system/files.hpp"

#include <array>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <fmt/format.h>
#include <sys/file.h>

#include "hal/linux/system/clock.hpp"

namespace smaservo::hal {
namespace {

[[noreturn]] void fail(const std::string& path) {
  throw DeviceError(fmt::format("{}: {}", path, std::strerror(errno)));
}

}  // namespace

Descriptor open_file(const std::string& path, int flags) {
  Descriptor file(open(path.c_str(), flags | O_CLOEXEC));
  if (file.number() < 0) {
    fail(path);
  }
  return file;
}

void take_output(int descriptor, const std::string& path, const LinuxRoots& roots) {
  if (!roots.takes_over && flock(descriptor, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
    throw DeviceBusy(path + ": another smaservod drives it");
  }
}

std::string read_text(const std::string& path) {
  const Descriptor file = open_file(path, O_RDONLY);
  std::array<char, 4096> text{};
  const ssize_t size = read(file.number(), text.data(), text.size());
  if (size < 0) {
    fail(path);
  }
  std::string_view line(text.data(), static_cast<std::size_t>(size));
  while (!line.empty() && (line.back() == '\n' || line.back() == ' ')) {
    line.remove_suffix(1);
  }
  return std::string(line);
}

double read_number(const std::string& path) {
  const std::string text = read_text(path);
  double value = 0;
  const auto [at, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || at != text.data() + text.size()) {
    throw DeviceError(fmt::format("{}: '{}' is not a number", path, text));
  }
  return value;
}

void write_text(const std::string& path, std::string_view text) {
  const Descriptor file = open_file(path, O_WRONLY | O_TRUNC);
  if (write(file.number(), text.data(), text.size()) != static_cast<ssize_t>(text.size())) {
    throw DeviceError(fmt::format("{}: '{}': {}", path, text, std::strerror(errno)));
  }
}

bool exists(const std::string& path) {
  return access(path.c_str(), F_OK) == 0;
}

void wait_until_writable(const std::string& path) {
  for (int i = 0; i < 100 && access(path.c_str(), W_OK) != 0; ++i) {
    MonotonicClock::sleep_until(MonotonicClock::now_ns() + 5'000'000);
  }
}

std::string find_by_name(const std::string& parent, const std::string& prefix,
                         const std::string& name) {
  std::string others;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(parent, error)) {
    const std::string file = entry.path().filename().string();
    if (!file.starts_with(prefix) || !exists(entry.path() / "name")) {
      continue;
    }
    const std::string its_name = read_text(entry.path() / "name");
    if (its_name == name) {
      return entry.path();
    }
    others += (others.empty() ? "" : ", ") + its_name;
  }
  if (error) {
    throw DeviceError(fmt::format("{}: {}", parent, error.message()));
  }
  throw DeviceError(fmt::format("{}/{}*: none is called '{}'; there is: {}", parent, prefix, name,
                                others.empty() ? "nothing" : others));
}

bool put_number(int descriptor, std::int64_t number) {
  std::array<char, 24> text{};
  const char* const end = std::to_chars(text.data(), text.data() + text.size(), number).ptr;
  const auto size = static_cast<std::size_t>(end - text.data());
  return pwrite(descriptor, text.data(), size, 0) == static_cast<ssize_t>(size);
}

}  // namespace smaservo::hal
