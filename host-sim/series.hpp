#pragma once

#include <array>
#include <cstddef>
#include <vector>

namespace smaservo {

/// What the plots of a replay show, in the units of their axes. NaN leaves a gap.
struct PlotPoint {
  double time_s;
  double strain_percent, strain_sd_percent, strain_ref_percent;
  double resistance_ohm, resistance_model_ohm;
  double temperature_degC, temperature_ref_degC;
  double martensite, r_phase;
  double current_A, stress_MPa;
};

/// A whole run in a few thousand points: of each stretch of rows the ones with the smallest and
/// the greatest strain. When it is full, stretches become twice as long.
class Series {
 public:
  explicit Series(std::size_t most_points = 4096) : most_(most_points / 4 * 4) {}

  void add(const PlotPoint& point);
  /// All points in order, with the stretch that is not finished yet.
  std::vector<PlotPoint> points() const;

 private:
  struct Stretch {
    PlotPoint low, high;
    bool low_first;
  };
  static Stretch merged(const Stretch& a, const Stretch& b);

  std::size_t most_;
  std::size_t rows_per_stretch_ = 1;
  std::size_t rows_ = 0;  ///< in the open stretch
  Stretch open_{};
  std::vector<Stretch> stretches_;
};

}  // namespace smaservo
