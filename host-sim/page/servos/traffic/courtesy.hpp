#pragma once
// A servo has one SDO transfer at a time. After a request or an answer of another master's it is
// left alone for 30 ms, or that one's transfer would be dropped. A master that never pauses does
// not keep the bridge from knowing the servo: after 5 s without an answer the bridge asks
// nevertheless.

#include <cstdint>

namespace smaservo::page {

class Courtesy {
 public:
  void foreign_request(std::int64_t now_us) { until_us_ = now_us + pause_us; }
  /// An answer that is not the bridge's.
  void foreign_answer(std::int64_t now_us) {
    if (now_us < until_us_) {
      until_us_ = now_us + pause_us;
    }
  }
  /// An answer to the bridge.
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
