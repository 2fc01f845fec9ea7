#pragma once
// The polling of one servo's state: its objects in turn, then a pause.

#include "host-sim/page/servos/servo.hpp"

namespace smaservo::page {

class StateRound {
 public:
  /// The next object is the first one, at once.
  void restart() { *this = {}; }

  /// The object that is to be read now, if it is time for one. While nobody looks, not `all` of
  /// the objects are read but the first, and less often.
  std::optional<Key> next(bool all, std::int64_t now_us) {
    if (is_complete(all)) {
      at_ = 0;
      due_us_ = now_us + (all ? period_us : idle_period_us);
    }
    return now_us < due_us_ ? std::nullopt : std::optional(state_objects()[at_++].key);
  }

  /// Whether all objects of the round have been asked for.
  bool is_complete(bool all) const { return at_ >= (all ? state_objects().size() : 1); }

  /// What the rounds of one servo take of the bus while somebody looks.
  static double requests_per_s() {
    return 1e6 / period_us * static_cast<double>(state_objects().size());
  }

 private:
  static constexpr std::int64_t period_us = 200'000;
  static constexpr std::int64_t idle_period_us = 1'000'000;

  std::size_t at_ = 0;
  std::int64_t due_us_ = 0;
};

}  // namespace smaservo::page
