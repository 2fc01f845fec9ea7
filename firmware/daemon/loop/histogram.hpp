#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace smaservo::daemon {

/// Histogram of times up to centuries, in bins 3 % wide, exact below 64 ns. One thread adds, any
/// thread reads. Cost of add(): about 10 operations.
class Histogram {
 public:
  void add(std::int64_t time_ns) {
    const auto ns = static_cast<std::uint64_t>(std::max<std::int64_t>(time_ns, 0));
    grow(bins_[bin_of(ns)], 1);
    grow(sum_ns_, ns);
    if (ns > max_ns_.load(std::memory_order_relaxed)) {
      max_ns_.store(ns, std::memory_order_relaxed);
    }
    grow(count_, 1);
  }

  std::uint64_t count() const { return count_.load(std::memory_order_relaxed); }
  /// This and the functions below give 0 where nothing has been added.
  std::int64_t max_ns() const {
    return static_cast<std::int64_t>(max_ns_.load(std::memory_order_relaxed));
  }
  double mean_ns() const {
    const auto n = static_cast<double>(std::max<std::uint64_t>(count(), 1));
    return static_cast<double>(sum_ns_.load(std::memory_order_relaxed)) / n;
  }
  /// The time that this share (0..1) of all times does not exceed, rounded up to the end of its
  /// bin.
  std::int64_t quantile_ns(double share) const {
    const auto wanted = static_cast<std::uint64_t>(std::ceil(share * static_cast<double>(count())));
    std::uint64_t seen = 0;
    for (std::size_t i = 0; i < bins_.size(); ++i) {
      seen += bins_[i].load(std::memory_order_relaxed);
      if (seen >= wanted && seen > 0) {
        return std::min(last_of(i), max_ns());
      }
    }
    return max_ns();
  }

 private:
  static constexpr unsigned step_bits = 5;
  static constexpr std::size_t steps = std::size_t{1} << step_bits;

  // Only one thread writes, so the addition need not be atomic.
  static void grow(std::atomic<std::uint64_t>& value, std::uint64_t by) {
    value.store(value.load(std::memory_order_relaxed) + by, std::memory_order_relaxed);
  }
  static std::size_t bin_of(std::uint64_t ns) {
    if (ns < 2 * steps) {
      return static_cast<std::size_t>(ns);
    }
    const unsigned shift = static_cast<unsigned>(std::bit_width(ns)) - step_bits - 1;
    return shift * steps + static_cast<std::size_t>(ns >> shift);
  }
  static std::int64_t last_of(std::size_t bin) {
    if (bin < 2 * steps) {
      return static_cast<std::int64_t>(bin);
    }
    const std::size_t shift = bin / steps - 1;
    return static_cast<std::int64_t>(((bin - shift * steps + 1) << shift) - 1);
  }

  std::array<std::atomic<std::uint64_t>, 60 * steps> bins_{};
  std::atomic<std::uint64_t> count_{0}, sum_ns_{0}, max_ns_{0};
};

}  // namespace smaservo::daemon
