#pragma once
// The other side of a test in a guest: commands of its shell.

#include <cstdio>
#include <stdexcept>
#include <string>

namespace smaservo {

/// What the command has said; one that fails, throws.
inline std::string run(const std::string& command) {
  // NOLINTNEXTLINE(bugprone-command-processor): the shell is meant
  std::FILE* pipe = popen(command.c_str(), "r");
  if (pipe == nullptr) {
    throw std::runtime_error("no shell");
  }
  std::string said;
  for (int c = std::fgetc(pipe); c != EOF; c = std::fgetc(pipe)) {
    said += static_cast<char>(c);
  }
  if (pclose(pipe) != 0) {
    throw std::runtime_error("failed: " + command + "\n" + said);
  }
  return said;
}

}  // namespace smaservo
