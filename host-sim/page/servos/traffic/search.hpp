#pragma once
// Chooses the node-ids to ask for a servo: those that were proposed, because a client has named
// them or they have sent something, and all others in turn, to find servos that send nothing by
// themselves.

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

  /// Whether to ask this node now, which is not online; it is asked again only after a pause. A
  /// known servo is asked without being proposed.
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
