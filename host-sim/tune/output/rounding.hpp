#pragma once
// Numbers rounded as a person would write them.

#include <cmath>

namespace smaservo::tune {

/// Rounds to three digits, downwards or upwards; 0 stays 0. Numbers of up to three digits, such as
/// 2.5e-3, are not changed.
inline double rounded(double x, bool up) {
  if (!(x > 0)) {
    return 0;
  }
  const double place = std::floor(std::log10(x)) - 2;
  const double many = x * std::pow(10.0, -place);
  const double near = std::round(many);
  const double digits = std::abs(many - near) < 1e-9 * many ? near
                        : up                                ? std::ceil(many)
                                                            : std::floor(many);
  return place < 0 ? digits / std::pow(10.0, -place) : digits * std::pow(10.0, place);
}
inline double rounded_up(double x) {
  return rounded(x, true);
}
inline double rounded_down(double x) {
  return rounded(x, false);
}

}  // namespace smaservo::tune
