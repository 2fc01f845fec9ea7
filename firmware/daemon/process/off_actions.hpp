#pragma once
// System calls, prepared in advance, that switch a board's outputs off: for a signal handler, and
// for the guard while the loop hangs.

#include <cstddef>
#include <vector>

#include "hal/linux/system/off_action.hpp"

namespace smaservo::daemon {

/// The board's off_actions(); empty for a board without this function.
template <class B>
std::vector<hal::OffAction> off_actions_of(const B& board) {
  if constexpr (requires { board.off_actions(); }) {
    return board.off_actions();
  } else {
    return {};
  }
}

}  // namespace smaservo::daemon
