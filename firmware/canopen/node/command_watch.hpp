#pragma once
// Whether whoever commands the axis is still there: a dead-man watch.
//
// Only what commands counts: a written set-point, mode or controlword, also with the value that it
// had. Reading, tuning and network management do not, since anybody on the bus may do that while
// the commander has long gone. Frames on CAN have no sender, so that a second commander counts,
// too.

#include <algorithm>
#include <cstdint>

#include "firmware/canopen/node/object.hpp"

namespace smaservo::canopen {

class CommandWatch {
 public:
  /// So many PDOs in a row, none later than this after the one before, make a source that sends
  /// cyclically. Fewer may be a source that sends on events and has just enabled the axis.
  static constexpr std::uint64_t cyclic_gap_us = 500'000;
  static constexpr unsigned cyclic_pdos = 10;
  /// And this is the longest silence of such a source.
  static constexpr std::uint64_t cyclic_timeout_us = 1'000'000;

  void reset() { *this = CommandWatch{}; }

  /// An object that commands has been written.
  void commanded(std::uint64_t now_us, Source source) {
    if (source == Source::rpdo && now_us != pdo_us_) {  // one PDO may write several objects
      in_a_row_ = now_us - pdo_us_ <= cyclic_gap_us ? std::min(in_a_row_ + 1, cyclic_pdos) : 1;
      pdo_us_ = now_us;
    }
    last_us_ = now_us;
    has_commanded_ = true;
  }

  bool is_cyclic() const { return in_a_row_ == cyclic_pdos; }
  /// Whether the last command is no older than `timeout_us`, and than cyclic_timeout_us of a source
  /// that sends cyclically.
  bool is_alive(std::uint64_t now_us, std::uint64_t timeout_us) const {
    const std::uint64_t longest_us =
        is_cyclic() ? std::min(timeout_us, cyclic_timeout_us) : timeout_us;
    return has_commanded_ && now_us - last_us_ <= longest_us;
  }

 private:
  std::uint64_t last_us_ = 0, pdo_us_ = 0;
  unsigned in_a_row_ = 0;
  bool has_commanded_ = false;
};

}  // namespace smaservo::canopen
