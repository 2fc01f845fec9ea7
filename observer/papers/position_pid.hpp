#pragma once
// The controller of paper 002's position loop (section 5), which acts on the estimated strain.

#include <algorithm>

namespace smaservo::papers {

/// Gains from strain to current, per unit of strain.
struct PidGains {
  double proportional_A;
  double integral_A_s;
  double derivative_As;
  double min_current_A;  ///< keeps the resistance measurable
  double max_current_A;  ///< greatest current that the wire bears
};

/// The controller acts on strain - goal, because more current makes the wire shorter. The integral
/// is frozen while the current is at a limit and the error would drive it beyond.
class PidController {
 public:
  explicit PidController(const PidGains& gains) : gains_(gains) {}

  double current_A(double goal, double strain, double dt_s) {
    constexpr double smoothing_s = 0.02;  // time constant of the low-pass on the derivative
    const double error = strain - goal;
    before_ = first_ ? strain : before_;
    first_ = false;
    const double rise = (strain - before_) / (smoothing_s + dt_s);
    before_ += rise * dt_s;
    const double wanted_A =
        gains_.proportional_A * error + integral_A_ + gains_.derivative_As * rise;
    const bool above = wanted_A > gains_.max_current_A;
    const bool below = wanted_A < gains_.min_current_A;
    if (!(above && error > 0) && !(below && error < 0)) {
      integral_A_ += gains_.integral_A_s * error * dt_s;
    }
    return std::clamp(wanted_A, gains_.min_current_A, gains_.max_current_A);
  }

 private:
  PidGains gains_;
  double integral_A_ = 0;
  double before_ = 0;  ///< smoothed strain of the last step
  bool first_ = true;
};

}  // namespace smaservo::papers
