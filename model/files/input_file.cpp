#include "model/files/input_file.hpp"

#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <sstream>

#include "model/files/error.hpp"

namespace smaservo::files {

std::string whole_file(const std::string& path) {
  const std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  // Of an empty file nothing is copied, which the stream calls a failure.
  std::error_code error;
  if (!in || (!(text << in.rdbuf()) && !std::filesystem::is_empty(path, error)) ||
      std::filesystem::is_directory(path, error)) {
    throw ConfigError(fmt::format("{}: cannot be read", path));
  }
  return text.str();
}

}  // namespace smaservo::files
