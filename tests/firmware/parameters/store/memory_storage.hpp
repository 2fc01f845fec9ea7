#pragma once
// A storage in memory whose power can be cut at any byte.

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "firmware/parameters/store/store.hpp"

namespace smaservo {

/// What a cut leaves of a slot that was being erased or written.
enum class Rest { kept, erased, garbage };

class MemoryStorage {
 public:
  static constexpr std::size_t slot_size = 2048;

  bool read(unsigned slot, std::size_t offset, std::span<std::byte> to) {
    if (fail_reads || !powered_ || offset + to.size() > slot_size) {
      return false;
    }
    std::copy_n(slots[slot].begin() + static_cast<std::ptrdiff_t>(offset), to.size(), to.begin());
    return true;
  }
  bool erase(unsigned slot) {
    const std::vector<std::byte> blank(slot_size, std::byte{0xFF});
    return change(slot, 0, blank);
  }
  bool write(unsigned slot, std::size_t offset, std::span<const std::byte> from) {
    return offset + from.size() <= slot_size && change(slot, offset, from);
  }
  bool sync() const { return powered_ && !fail_sync; }

  /// The next so many bytes are changed, then power fails.
  void cut_after(std::size_t bytes, Rest rest) {
    left_ = bytes;
    rest_ = rest;
  }
  void power_on() {
    powered_ = true;
    left_ = std::numeric_limits<std::size_t>::max();
  }
  std::size_t changed() const { return changed_; }

  std::array<std::vector<std::byte>, slot_count> slots{
      std::vector<std::byte>(slot_size, std::byte{0xFF}),
      std::vector<std::byte>(slot_size, std::byte{0xFF})};
  bool fail_reads = false;
  bool fail_sync = false;
  bool stuck_bit = false;  ///< one bit is never what is written

 private:
  static constexpr std::size_t stuck_byte = 100;

  bool change(unsigned slot, std::size_t offset, std::span<const std::byte> from) {
    if (!powered_) {
      return false;
    }
    auto& to = slots[slot];
    std::size_t i = 0;
    for (; i < from.size() && left_ > 0; ++i, --left_, ++changed_) {
      to[offset + i] = from[i];
    }
    if (stuck_bit && offset <= stuck_byte && stuck_byte < offset + i) {
      to[stuck_byte] ^= std::byte{4};
    }
    if (i == from.size()) {
      return true;
    }
    powered_ = false;
    for (; i < from.size() && rest_ != Rest::kept; ++i) {
      garbage_ = garbage_ * 1664525U + 1013904223U;
      to[offset + i] =
          rest_ == Rest::erased ? std::byte{0xFF} : static_cast<std::byte>(garbage_ >> 24U);
    }
    return false;
  }

  bool powered_ = true;
  std::size_t left_ = std::numeric_limits<std::size_t>::max();
  std::size_t changed_ = 0;
  Rest rest_ = Rest::kept;
  std::uint32_t garbage_ = 1;
};

static_assert(Storage<MemoryStorage>);

}  // namespace smaservo
