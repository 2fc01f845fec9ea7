#pragma once
// A dead-man watch: whether the source that commands the axis is still present.
//
// Only commands count: a written set-point, mode or controlword, even with an unchanged value.
// Reading, tuning and network management do not count, since any node on the bus may do that long
// after the commander has gone. CAN frames do not name their sender, so commands of a second
// commander count, too.

#include <algorithm>
#include <cstdint>

#include "firmware/canopen/node/object.hpp"

namespace smaservo::canopen {

class CommandWatch {
 public:
  /// `cyclic_pdos` PDOs in a row, none later than this after the one before, show that the source
  /// sends cyclically. Fewer may come from a source that sends on events and has just enabled the
  /// axis.
  static constexpr std::uint64_t cyclic_gap_us = 500'000;
  static constexpr unsigned cyclic_pdos = 10;
  /// The longest silence that is allowed to a source that sends cyclically.
  static constexpr std::uint64_t cyclic_timeout_us = 1'000'000;

  void reset() { *this = CommandWatch{}; }

  /// To be called when an object that commands has been written.
  void commanded(std::uint64_t now_us, Source source) {
    if (source == Source::rpdo && now_us != pdo_us_) {  // one PDO may write several objects
      in_a_row_ = now_us - pdo_us_ <= cyclic_gap_us ? std::min(in_a_row_ + 1, cyclic_pdos) : 1;
      pdo_us_ = now_us;
    }
    last_us_ = now_us;
    has_commanded_ = true;
  }

  bool is_cyclic() const { return in_a_row_ == cyclic_pdos; }
  /// Whether the last command is no older than `timeout_us`; for a source that sends cyclically, no
  /// older than cyclic_timeout_us either.
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
