#pragma once
// Decides when the bridge may send SDO requests to a servo that another master uses. A servo has
// one SDO transfer at a time. After a request or answer of another master, the servo is left alone
// for 30 ms, because a request of ours would drop that master's transfer. If that master never
// pauses, the bridge sends its request after 5 s without an answer nevertheless.

#include <cstdint>

namespace smaservo::page {

class Courtesy {
 public:
  void foreign_request(std::int64_t now_us) { until_us_ = now_us + pause_us; }
  /// Notes an answer to another master's request.
  void foreign_answer(std::int64_t now_us) {
    if (now_us < until_us_) {
      until_us_ = now_us + pause_us;
    }
  }
  /// Notes an answer to a request of the bridge.
  void answered(std::int64_t now_us) { answered_us_ = now_us; }

  bool forbids(std::int64_t now_us) const {
    return now_us < until_us_ && now_us - answered_us_ < longest_us;
  }

 private:
  static constexpr std::int64_t pause_us = 30'000;
  static constexpr std::int64_t longest_us = 5'000'000;

  std::int64_t until_us_ = 0, answered_us_ = -1'000'000;
};

}  // namespace smaservo::page
