#pragma once
// What tells that a wire is not the one that was described: the same with and without a bus.

namespace smaservo::commission {

/// Greatest relative deviation of the cold resistance. The makers state the resistance within 5 to
/// 10 %; a diameter that is a size off differs by 30 % and more.
inline constexpr double most_cold_deviation = 0.10;
/// Least stress. Below it nothing stretches NiTi again as it cools, so that there is no stroke.
inline constexpr double least_stress_Pa = 5e6;

}  // namespace smaservo::commission
