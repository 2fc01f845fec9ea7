#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace smaservo {

/// The turning points of one direction that are still open, newest last, above one that lies at
/// infinity and is never removed.
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

  /// A full list stays as it is: the owner makes room before.
  constexpr void push(const Turn& turn) {
    if (!full()) {
      turns_[++top_] = turn;
    }
  }
  constexpr void pop() { top_ = static_cast<std::uint8_t>(top_ - (top_ > 0 ? 1 : 0)); }

  /// Removes turning point i, 1..size().
  constexpr void erase(std::size_t i) {
    for (; i < top_; ++i) {
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
