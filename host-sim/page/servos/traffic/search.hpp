#pragma once
// Which node-ids are asked whether a servo answers there: those that somebody has named or that
// have said something, and one after the other, so that a servo is found that says nothing by
// itself.

#include <array>

#include "host-sim/page/servos/control.hpp"

namespace smaservo::page {

class Search {
 public:
  void propose(unsigned node, bool proposed = true) { proposed_.set(node, proposed); }
  bool is_proposed(unsigned node) const { return proposed_[node]; }

  /// Proposes another node-id each 0.1 s, unless a servo is known there.
  template <class IsKnown>
  void tick(std::int64_t now_us, const IsKnown& is_known) {
    if (now_us - last_us_ < period_us) {
      return;
    }
    last_us_ = now_us;
    if (!is_known(at_)) {
      propose(at_);
    }
    at_ = at_ % 127 + 1;
  }

  /// Whether this node, which is not online, is to be asked now; it is then asked again after a
  /// pause. One that is known is asked without being proposed.
  bool takes(unsigned node, bool is_known, std::int64_t now_us) {
    if (now_us < next_try_us_[node] || (!is_known && !proposed_[node])) {
      return false;
    }
    next_try_us_[node] = now_us + pause_us;
    proposed_.reset(node);
    return true;
  }

 private:
  static constexpr std::int64_t period_us = 100'000;
  static constexpr std::int64_t pause_us = 500'000;

  NodeSet proposed_;
  std::array<std::int64_t, 128> next_try_us_{};
  std::int64_t last_us_ = 0;
  unsigned at_ = 1;
};

}  // namespace smaservo::page
