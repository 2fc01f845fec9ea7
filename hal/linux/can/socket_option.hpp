#pragma once

#include <cerrno>
#include <sys/socket.h>

namespace smaservo::hal {

/// Calls setsockopt() and returns its errno; 0 if it succeeds.
template <class Value>
int set_option(int socket, int level, int option, const Value& value) {
  return setsockopt(socket, level, option, &value, sizeof value) == 0 ? 0 : errno;
}

}  // namespace smaservo::hal
