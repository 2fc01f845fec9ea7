#pragma once

#include <cstddef>
#include <vector>

namespace smaservo::report {

/// A whole run in a few thousand points, each with a time_s: of each stretch of rows the ones with
/// the smallest and the greatest `key`. When it is full, stretches become twice as long.
template <class Point, double Point::* key>
class SeriesOf {
 public:
  explicit SeriesOf(std::size_t max_points = 4096) : max_(max_points / 4 * 4) {}

  void add(const Point& point) {
    const Stretch single{point, point, true};
    open_ = rows_ == 0 ? single : merged(open_, single);
    if (++rows_ < rows_per_stretch_) {
      return;
    }
    rows_ = 0;
    stretches_.push_back(open_);
    if (2 * stretches_.size() >= max_) {
      for (std::size_t i = 0; i + 1 < stretches_.size(); i += 2) {
        stretches_[i / 2] = merged(stretches_[i], stretches_[i + 1]);
      }
      stretches_.resize(stretches_.size() / 2);
      rows_per_stretch_ *= 2;
    }
  }

  /// All points in order, with the stretch that is not finished yet.
  std::vector<Point> points() const {
    std::vector<Point> all;
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

 private:
  struct Stretch {
    Point low, high;
    bool low_first;
  };
  static Stretch merged(const Stretch& a, const Stretch& b) {
    const Point& low = b.low.*key < a.low.*key ? b.low : a.low;
    const Point& high = b.high.*key > a.high.*key ? b.high : a.high;
    return {low, high, low.time_s <= high.time_s};
  }

  std::size_t max_;
  std::size_t rows_per_stretch_ = 1;
  std::size_t rows_ = 0;  ///< in the open stretch
  Stretch open_{};
  std::vector<Stretch> stretches_;
};

/// One point of a replay's plots, in the units of their axes. NaN leaves a gap.
struct PlotPoint {
  double time_s;
  double strain_percent, strain_sd_percent, strain_ref_percent;
  double resistance_ohm, resistance_model_ohm;
  double temperature_degC, temperature_ref_degC;
  double martensite, r_phase;
  double current_A, stress_MPa;
};
using Series = SeriesOf<PlotPoint, &PlotPoint::strain_percent>;

}  // namespace smaservo::report
