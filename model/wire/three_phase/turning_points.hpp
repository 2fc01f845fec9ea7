#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace smaservo {

/// The turning points of one direction that are still open, newest last, above one that lies at
/// infinity and is never removed. When the list is full, the owner drops the oldest pair: a branch
/// that passes all the others then heads for infinity a little early. Dropping the newest ones
/// instead would send every small loop along the branch of a large one.
template <class Turn, std::size_t depth>
class TurningPoints {
 public:
  TurningPoints() = default;
  /// Forgets all turning points and sets the one at infinity.
  constexpr void start(const Turn& at_infinity) {
    turns_ = {};
    turns_[0] = at_infinity;
    top_ = 0;
  }

  constexpr const Turn& newest() const { return turns_[top_]; }
  constexpr Turn& newest() { return turns_[top_]; }
  constexpr bool full() const { return top_ == depth; }
  constexpr std::size_t size() const { return top_; }
  /// Index 0 is the turning point at infinity, size() the newest.
  constexpr const Turn& at(std::size_t i) const { return turns_[i]; }

  /// The list must not be full.
  constexpr void push(const Turn& turn) { turns_[++top_] = turn; }
  constexpr void pop() { top_ = static_cast<std::uint8_t>(top_ - (top_ > 0 ? 1 : 0)); }

  constexpr void drop_oldest() {
    for (std::size_t i = 1; i < top_; ++i) {
      turns_[i] = turns_[i + 1];
    }
    pop();
  }

  /// The range of all turning points except the one at infinity.
  constexpr Turn* begin() { return turns_.data() + 1; }
  constexpr Turn* end() { return turns_.data() + 1 + top_; }

 private:
  std::array<Turn, depth + 1> turns_{};
  std::uint8_t top_ = 0;
};

}  // namespace smaservo
