#include "host-sim/series.hpp"

namespace smaservo {

Series::Stretch Series::merged(const Stretch& a, const Stretch& b) {
  const PlotPoint& low = b.low.strain_percent < a.low.strain_percent ? b.low : a.low;
  const PlotPoint& high = b.high.strain_percent > a.high.strain_percent ? b.high : a.high;
  return {low, high, low.time_s <= high.time_s};
}

void Series::add(const PlotPoint& point) {
  const Stretch single{point, point, true};
  open_ = rows_ == 0 ? single : merged(open_, single);
  if (++rows_ < rows_per_stretch_) {
    return;
  }
  rows_ = 0;
  stretches_.push_back(open_);
  if (2 * stretches_.size() >= most_) {
    for (std::size_t i = 0; i + 1 < stretches_.size(); i += 2) {
      stretches_[i / 2] = merged(stretches_[i], stretches_[i + 1]);
    }
    stretches_.resize(stretches_.size() / 2);
    rows_per_stretch_ *= 2;
  }
}

std::vector<PlotPoint> Series::points() const {
  std::vector<PlotPoint> all;
  const auto put = [&](const Stretch& s) {
    const bool same = s.low.time_s == s.high.time_s;
    all.push_back(s.low_first ? s.low : s.high);
    if (!same) {
      all.push_back(s.low_first ? s.high : s.low);
    }
  };
  for (const Stretch& stretch : stretches_) {
    put(stretch);
  }
  if (rows_ > 0) {
    put(open_);
  }
  return all;
}

}  // namespace smaservo
