#pragma once

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fmt/format.h>
#include <string>
#include <system_error>

#include "model/files/error.hpp"

namespace smaservo {

/// A temporary folder that is removed with its owner.
class TemporaryFolder {
 public:
  /// Throws UserError if it cannot be created.
  TemporaryFolder() {
    std::error_code missing;
    const std::filesystem::path where = std::filesystem::temp_directory_path(missing);
    if (missing) {
      throw files::UserError(
          fmt::format("the folder for temporary files, {}: {}; let TMPDIR name one that exists",
                      where.string(), missing.message()));
    }
    std::string name = (where / "host-sim-XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) {
      throw files::UserError(fmt::format("{}: {}", name, std::strerror(errno)));
    }
    path_ = name;
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  std::filesystem::path operator/(const char* name) const { return path_ / name; }

 private:
  std::filesystem::path path_;
};

}  // namespace smaservo
