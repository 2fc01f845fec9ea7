#include "host-sim/replay/error_statistics.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <utility>

namespace smaservo::replay {
namespace {

constexpr double bin_percent = 0.01;
constexpr std::size_t max_bins = 100'000;  // 1000 %; beyond it only the maximum counts

}  // namespace

ErrorStatistics::ErrorStatistics(std::vector<std::uint64_t> bins, double sum, double maximum)
    : bins_(std::move(bins)),
      count_(std::accumulate(bins_.begin(), bins_.end(), std::uint64_t{0})),
      sum_(sum),
      maximum_(maximum) {}

void ErrorStatistics::add(double percent) {
  // An estimate that is NaN counts as infinitely wrong.
  const double size =
      std::isnan(percent) ? std::numeric_limits<double>::infinity() : std::abs(percent);
  const double place = std::min(std::floor(size / bin_percent), double{max_bins - 1});
  const auto bin = static_cast<std::size_t>(place);
  if (bin >= bins_.size()) {
    bins_.resize(bin + 1);
  }
  ++bins_[bin];
  ++count_;
  sum_ += size;
  maximum_ = std::max(maximum_, size);
}

void ErrorStatistics::add(const ErrorStatistics& others) {
  bins_.resize(std::max(bins_.size(), others.bins_.size()));
  std::ranges::transform(others.bins_, bins_, bins_.begin(), std::plus{});
  count_ += others.count_;
  sum_ += others.sum_;
  maximum_ = std::max(maximum_, others.maximum_);
}

double ErrorStatistics::quantile(double share) const {
  const double wanted = share * static_cast<double>(count_);
  std::uint64_t seen = 0;
  for (std::size_t bin = 0; bin < bins_.size(); ++bin) {
    seen += bins_[bin];
    if (static_cast<double>(seen) >= wanted) {
      return std::min(static_cast<double>(bin + 1) * bin_percent, maximum_);
    }
  }
  return maximum_;
}

}  // namespace smaservo::replay
