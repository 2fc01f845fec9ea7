#pragma once

#include <cstddef>
#include <span>
#include <sys/ioctl.h>
#include <unistd.h>

namespace smaservo::hal {

/// One system call that switches an output off. `data` lives as long as the board.
struct OffAction {
  int descriptor;
  unsigned long request;  ///< request of ioctl(); 0: the call is pwrite() to the file's beginning
  void* data;
  std::size_t size;  ///< bytes of `data`, for pwrite()
};

/// Makes all calls, even if some fail. Safe in a signal handler.
inline void switch_off(std::span<const OffAction> actions) {
  for (const OffAction& action : actions) {
    if (action.request != 0) {
      ioctl(action.descriptor, action.request, action.data);
    } else if (pwrite(action.descriptor, action.data, action.size, 0) < 0) {
      continue;
    }
  }
}

}  // namespace smaservo::hal
