#pragma once
// The polling of one servo's state: its objects in turn, then a pause.

#include "host-sim/page/servos/servo.hpp"

namespace smaservo::page {

class StateRound {
 public:
  /// Begins a new round at once.
  void restart() { *this = {}; }

  /// The object to read now, if one is due. Without `all` only the first object is read, with the
  /// longer period. Counts of warnings that do not stand are left out.
  std::optional<Key> next(const Servo& servo, bool all, std::int64_t now_us) {
    if (is_complete(all)) {
      at_ = 0;
      due_us_ = now_us + (all ? period_us : idle_period_us);
    }
    if (now_us < due_us_) {
      return std::nullopt;
    }
    // The last object is none of these counts, so that a round always ends with a request.
    while (is_idle_count(servo, state_objects()[at_].key)) {
      ++at_;
    }
    return state_objects()[at_++].key;
  }

  /// Whether all objects of the round have been requested.
  bool is_complete(bool all) const { return at_ >= (all ? state_objects().size() : 1); }

  /// Rate of the requests for one servo's state, with all objects but the counts of warnings.
  static double requests_per_s() {
    return 1e6 / period_us * static_cast<double>(state_objects().size() - warning_count);
  }

 private:
  static constexpr std::int64_t period_us = 200'000;
  /// Period of the state requests while no client subscribes to anything or has control.
  static constexpr std::int64_t idle_period_us = 1'000'000;

  std::size_t at_ = 0;
  std::int64_t due_us_ = 0;
};

}  // namespace smaservo::page
