#pragma once

#include <cstdint>
#include <vector>

namespace smaservo::replay {

/// Mean, 95 % quantile and maximum of errors in per cent, in constant memory: the quantile is
/// rounded up to 0.01 %.
class ErrorStatistics {
 public:
  ErrorStatistics() = default;
  /// What others have counted: bins(), sum() and maximum().
  ErrorStatistics(std::vector<std::uint64_t> bins, double sum, double maximum);

  void add(double percent);
  void add(const ErrorStatistics& others);

  std::uint64_t count() const { return count_; }
  double mean() const { return count_ == 0 ? 0 : sum_ / static_cast<double>(count_); }
  double quantile(double share) const;
  double maximum() const { return maximum_; }
  double sum() const { return sum_; }
  /// Numbers of errors in [0.01 i, 0.01 (i + 1)) %; the last possible one has all beyond 1000 %.
  const std::vector<std::uint64_t>& bins() const { return bins_; }

 private:
  std::vector<std::uint64_t> bins_;
  std::uint64_t count_ = 0;
  double sum_ = 0;
  double maximum_ = 0;
};

}  // namespace smaservo::replay
