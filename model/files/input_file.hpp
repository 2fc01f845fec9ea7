#pragma once

#include <string>

namespace smaservo::files {

/// The whole content of a file, which may be empty. Throws ConfigError if it cannot be read.
std::string whole_file(const std::string& path);

}  // namespace smaservo::files
