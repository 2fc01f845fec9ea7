#pragma once

#include <cerrno>
#include <sys/socket.h>

namespace smaservo::hal {

/// As setsockopt(), but the error is the result; 0: none.
template <class Value>
int set_option(int socket, int level, int option, const Value& value) {
  return setsockopt(socket, level, option, &value, sizeof value) == 0 ? 0 : errno;
}

}  // namespace smaservo::hal
