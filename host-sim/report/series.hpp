#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace smaservo::report {

/// A run of any length, collected as some thousand points: in each stretch of rows those in which
/// one of the `values` is smallest or greatest, so that no peak is lost. When there are too many
/// points, stretches become twice as long. The first and the last point are kept as well. A value
/// that is not finite is no peak; a stretch without finite values keeps its first point.
template <class Point, double Point::*... values>
class SeriesOf {
 public:
  explicit SeriesOf(std::size_t max_points = 20'000) : max_(max_points) {}

  void add(const Point& point) {
    open_.push_back({rows_, point});
    last_ = point;
    ++rows_;
    if (++rows_in_open_ < rows_per_stretch_) {
      if (open_.size() >= crowded) {
        keep_peaks(open_);
      }
      return;
    }
    close();
  }

  /// All points in order: at most `max_points`, plus those of the unfinished stretch.
  std::vector<Point> points() const {
    std::vector<Point> all;
    const auto put = [&](const Stretch& stretch) {
      for (const Row& row : stretch) {
        all.push_back(row.point);
      }
    };
    for (const Stretch& stretch : stretches_) {
      put(stretch);
    }
    put(open_);
    const Stretch* const end = !open_.empty()       ? &open_
                               : stretches_.empty() ? nullptr
                                                    : &stretches_.back();
    if (end != nullptr && end->back().number + 1 < rows_) {
      all.push_back(last_);
    }
    return all;
  }

 private:
  struct Row {
    std::uint64_t number;
    Point point;
  };
  using Stretch = std::vector<Row>;
  static constexpr std::size_t peaks = 2 * sizeof...(values);
  static constexpr std::size_t crowded =
      2 * peaks + 64;  ///< number of rows of a stretch at which it is thinned

  /// Ends the open stretch; doubles the length of all stretches until there are few enough points.
  void close() {
    keep_peaks(open_);
    total_ += open_.size();
    stretches_.push_back(std::move(open_));
    open_.clear();
    rows_in_open_ = 0;
    if (total_ <= max_) {
      return;
    }
    // Thins to three quarters, so that it is not repeated for every stretch.
    while (4 * total_ > 3 * max_ && stretches_.size() > 1) {
      halve();
    }
  }

  void halve() {
    rows_per_stretch_ *= 2;
    total_ = 0;
    std::vector<Stretch> fewer;
    for (std::size_t i = 0; i < stretches_.size(); i += 2) {
      Stretch& both = fewer.emplace_back(std::move(stretches_[i]));
      if (i + 1 < stretches_.size()) {
        both.insert(both.end(), stretches_[i + 1].begin(), stretches_[i + 1].end());
        keep_peaks(both);
        total_ += both.size();
      } else {
        // A single stretch is half of a new one and is continued.
        both.insert(both.end(), open_.begin(), open_.end());
        open_ = std::move(both);
        rows_in_open_ += rows_per_stretch_ / 2;
        fewer.pop_back();
      }
    }
    stretches_ = std::move(fewer);
  }

  static void keep_peaks(Stretch& rows) {
    if (rows.size() <= 1) {
      return;
    }
    std::vector<bool> kept(rows.size(), false);
    (keep(rows, values, kept), ...);
    if (std::ranges::find(kept, true) == kept.end() || rows.front().number == 0) {
      kept.front() = true;
    }
    std::size_t to = 0;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      if (kept[i]) {
        rows[to++] = rows[i];
      }
    }
    rows.resize(to);
  }

  static void keep(const Stretch& rows, double Point::* value, std::vector<bool>& kept) {
    std::size_t low = rows.size();
    std::size_t high = rows.size();
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const double here = rows[i].point.*value;
      if (std::isfinite(here)) {
        low = low == rows.size() || here < rows[low].point.*value ? i : low;
        high = high == rows.size() || here > rows[high].point.*value ? i : high;
      }
    }
    if (low != rows.size()) {
      kept[low] = kept[high] = true;
    }
  }

  std::size_t max_;
  std::uint64_t rows_per_stretch_ = 1;
  std::uint64_t rows_ = 0;
  std::uint64_t rows_in_open_ = 0;
  std::size_t total_ = 0;  ///< points of all finished stretches
  Stretch open_;
  std::vector<Stretch> stretches_;
  Point last_{};  ///< last point of the run
};

/// One point of a replay's plots, in the units of their axes. NaN leaves a gap.
struct PlotPoint {
  double time_s;
  double strain_percent, strain_sd_percent, strain_ref_percent;
  double error_percent;  ///< error in per cent of the nominal stroke
  double resistance_ohm, resistance_model_ohm;
  double temperature_degC, temperature_ref_degC;
  double martensite, r_phase;
  double current_A, stress_MPa;
};
using ReplaySeries =
    SeriesOf<PlotPoint, &PlotPoint::strain_percent, &PlotPoint::strain_sd_percent,
             &PlotPoint::strain_ref_percent, &PlotPoint::error_percent, &PlotPoint::resistance_ohm,
             &PlotPoint::resistance_model_ohm, &PlotPoint::temperature_degC,
             &PlotPoint::temperature_ref_degC, &PlotPoint::martensite, &PlotPoint::r_phase,
             &PlotPoint::current_A, &PlotPoint::stress_MPa>;

}  // namespace smaservo::report
