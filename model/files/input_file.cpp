#include "model/files/input_file.hpp"

#include <cerrno>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <sstream>
#include <system_error>

#include "model/files/error.hpp"

namespace smaservo::files {

std::string whole_file(const std::string& path) {
  errno = 0;
  const std::ifstream in(path, std::ios::binary);
  const int reason = errno;
  std::ostringstream text;
  // The stream calls it a failure when an empty file gives nothing to copy.
  std::error_code error;
  if (!in || (!(text << in.rdbuf()) && !std::filesystem::is_empty(path, error)) ||
      std::filesystem::is_directory(path, error)) {
    const bool is_folder = std::filesystem::is_directory(path, error);
    throw ConfigError(
        fmt::format("{}: cannot be read: {}", path,
                    is_folder ? "it is a folder"
                              : std::generic_category().message(reason != 0 ? reason : EIO)));
  }
  return text.str();
}

}  // namespace smaservo::files
