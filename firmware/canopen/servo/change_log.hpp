#pragma once
// The last changes and refusals of writes over the bus, with old and new value, source and result.

#include <array>

#include "firmware/canopen/node/object.hpp"

namespace smaservo::canopen {

struct LoggedChange {
  std::uint32_t time_ms;  ///< the node's time; wraps after 49 days
  Key key;
  Source source;
  std::uint32_t before, value;  ///< bits as sent; for a REAL32, those of the float
  Abort result;                 ///< Abort::none, or the reason of the refusal
};

class ChangeLog {
 public:
  static constexpr std::size_t capacity = 16;
  static constexpr std::size_t bytes = 20;  ///< bytes of an entry when it is read

  /// A refused write that a PDO repeats is logged only once.
  void add(const LoggedChange& change) {
    if (change.source == Source::rpdo && change.result != Abort::none && stands(change)) {
      return;
    }
    ring_[count_ % capacity] = change;
    ++count_;
  }
  std::uint32_t count() const { return count_; }
  std::uint32_t kept() const {
    return count_ < capacity ? count_ : static_cast<std::uint32_t>(capacity);
  }
  /// The i-th newest entry, counted from 0.
  const LoggedChange& last(std::uint32_t i) const { return ring_[(count_ - 1 - i) % capacity]; }
  /// Gives the next change that the owner has not taken yet, for its own log; false if there is
  /// none. Overwritten changes are skipped.
  bool take(LoggedChange& change) {
    if (taken_ == count_) {
      return false;
    }
    taken_ = capacity < count_ - taken_ ? count_ - static_cast<std::uint32_t>(capacity) : taken_;
    change = ring_[taken_++ % capacity];
    return true;
  }
  void read(std::uint32_t offset, std::span<std::uint8_t> to) const {
    for (std::uint8_t& byte : to) {
      std::array<std::uint8_t, bytes> entry{};
      const LoggedChange& c = last(offset / bytes);
      const std::span<std::uint8_t> all(entry);
      put_number(all.first(4), c.time_ms);
      put_number(all.subspan(4, 2), c.key.index);
      entry[6] = c.key.sub;
      entry[7] = static_cast<std::uint8_t>(c.source);
      put_number(all.subspan(8, 4), c.before);
      put_number(all.subspan(12, 4), c.value);
      put_number(all.subspan(16, 4), static_cast<std::uint32_t>(c.result));
      byte = entry[offset % bytes];
      ++offset;
    }
  }

 private:
  bool stands(const LoggedChange& change) const {
    for (std::uint32_t i = 0; i < kept(); ++i) {
      const LoggedChange& c = last(i);
      if (c.key == change.key && c.source == change.source && c.value == change.value &&
          c.result == change.result) {
        return true;
      }
    }
    return false;
  }

  std::array<LoggedChange, capacity> ring_{};
  std::uint32_t count_ = 0, taken_ = 0;
};

}  // namespace smaservo::canopen
