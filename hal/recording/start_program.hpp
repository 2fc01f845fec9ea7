#pragma once

#include <string>
#include <sys/types.h>
#include <vector>

namespace smaservo::hal {

/// What a program is started with.
struct Start {
  std::string program;                 ///< its path
  std::vector<std::string> arguments;  ///< after its name
  int input, output, errors;           ///< open files that become its standard ones
  char* const* environment;            ///< ends in a null pointer
  bool own_group = false;              ///< a process group of its own, which a signal can end whole
};

/// Starts a program. No other open file reaches it, and no signal that its starter ignores or
/// blocks. Returns 0 and the number of the process, or an error of errno.
int start_program(const Start& start, pid_t& child);

}  // namespace smaservo::hal
