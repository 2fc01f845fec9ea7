#pragma once
// Detects two devices with one node-id, which both answer a request. An answer that comes within
// 50 ms of another one to the same request is surplus. Three of them, none more than 5 s after the
// one before, prove that there are two devices.

#include "firmware/parameters/key.hpp"

namespace smaservo::page {

class Duplicates {
 public:
  /// Notes the answer for which the bridge has waited.
  void answered(Key key, std::int64_t now_us) {
    answered_ = key;
    answered_us_ = now_us;
  }

  /// Notes a request of another master; the next answer may belong to it.
  void foreign_request(std::int64_t now_us) { foreign_us_ = now_us; }

  /// Notes an answer for which the bridge has not waited. Returns whether two devices are proved.
  bool answered_again(Key key, std::int64_t now_us) {
    if (key != answered_ || now_us - answered_us_ > second_answer_us ||
        now_us - foreign_us_ < 2 * second_answer_us) {
      return false;
    }
    surplus_ = is_over(now_us) ? 1 : surplus_ + 1;
    surplus_us_ = now_us;
    return surplus_ >= surplus_of_two;
  }

  /// Whether the last surplus answer is so long ago that one of two devices must have gone.
  bool is_over(std::int64_t now_us) const { return now_us - surplus_us_ > memory_us; }

 private:
  static constexpr unsigned surplus_of_two = 3;
  static constexpr std::int64_t second_answer_us = 50'000;
  static constexpr std::int64_t memory_us = 5'000'000;

  Key answered_{};
  std::int64_t answered_us_ = -1'000'000, foreign_us_ = -1'000'000;
  std::int64_t surplus_us_ = -1'000'000'000;
  unsigned surplus_ = 0;
};

}  // namespace smaservo::page
