#pragma once
// Classes that pass values from one thread to one other without locks. Neither thread ever waits,
// and nothing is allocated after the start.

#include <array>
#include <atomic>
#include <bit>
#include <cstddef>
#include <type_traits>
#include <vector>

namespace smaservo::daemon {

/// Alignment of what different threads write, so that they do not share a cache line.
inline constexpr std::size_t cache_line = 64;

/// Passes all values, in their order.
template <class T>
class Ring {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  /// Has room for at least this number of values. Its pages are touched here, so that the loop
  /// causes no page fault.
  explicit Ring(std::size_t room) : cells_(std::bit_ceil(room)), mask_(cells_.size() - 1) {}

  /// For the one thread that writes. Returns false, and writes nothing, if the ring is full.
  bool push(const T& value) {
    const std::size_t end = end_.load(std::memory_order_relaxed);
    if (end - begin_.load(std::memory_order_acquire) == cells_.size()) {
      return false;
    }
    cells_[end & mask_] = value;
    end_.store(end + 1, std::memory_order_release);
    return true;
  }

  /// For the one thread that reads. Returns false if the ring is empty.
  bool pop(T& value) {
    const std::size_t begin = begin_.load(std::memory_order_relaxed);
    if (begin == end_.load(std::memory_order_acquire)) {
      return false;
    }
    value = cells_[begin & mask_];
    begin_.store(begin + 1, std::memory_order_release);
    return true;
  }

  /// For the one thread that reads.
  bool empty() const {
    return begin_.load(std::memory_order_relaxed) == end_.load(std::memory_order_acquire);
  }

  std::size_t room() const { return cells_.size(); }

 private:
  std::vector<T> cells_;
  std::size_t mask_;
  alignas(cache_line) std::atomic<std::size_t> begin_{0};
  alignas(cache_line) std::atomic<std::size_t> end_{0};
};

/// Passes the newest value only.
template <class T>
class Latest {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  /// For the one thread that writes.
  void put(const T& value) {
    cells_[back_] = value;
    back_ = between_.exchange(back_ | unread, std::memory_order_acq_rel) & ~unread;
  }

  /// For the one thread that reads. Returns false if there is no new value.
  bool take(T& value) {
    if ((between_.load(std::memory_order_relaxed) & unread) == 0) {
      return false;
    }
    front_ = between_.exchange(front_, std::memory_order_acq_rel) & ~unread;
    value = cells_[front_];
    return true;
  }

 private:
  static constexpr unsigned unread = 4;

  std::array<T, 3> cells_{};
  alignas(cache_line) unsigned back_ = 0;
  alignas(cache_line) std::atomic<unsigned> between_{1};
  alignas(cache_line) unsigned front_ = 2;
};

}  // namespace smaservo::daemon
