#pragma once

#include <cstdint>
#include <vector>

namespace smaservo::replay {

/// Mean, 95 % quantile and maximum of errors in per cent, in constant memory: the quantile is
/// rounded up to 0.01 %.
class ErrorStatistics {
 public:
  void add(double percent);
  void add(const ErrorStatistics& others);

  std::uint64_t count() const { return count_; }
  double mean() const { return count_ == 0 ? 0 : sum_ / static_cast<double>(count_); }
  double quantile(double share) const;
  double maximum() const { return maximum_; }

 private:
  std::vector<std::uint64_t> bins_;
  std::uint64_t count_ = 0;
  double sum_ = 0;
  double maximum_ = 0;
};

}  // namespace smaservo::replay
