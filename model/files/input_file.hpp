#pragma once

#include <string>

namespace smaservo::files {

/// All that a file holds, which may be nothing. Throws ConfigError where it cannot be read.
std::string whole_file(const std::string& path);

}  // namespace smaservo::files
