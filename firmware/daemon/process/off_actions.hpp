#pragma once
// What switches a board's outputs off by system calls alone, prepared beforehand: for a signal
// handler, and for a guard while the loop hangs.

#include <cstddef>
#include <vector>

#include "hal/linux/system/off_action.hpp"

namespace smaservo::daemon {

/// A board with such outputs has off_actions().
template <class B>
std::vector<hal::OffAction> off_actions_of(const B& board) {
  if constexpr (requires { board.off_actions(); }) {
    return board.off_actions();
  } else {
    return {};
  }
}

}  // namespace smaservo::daemon
