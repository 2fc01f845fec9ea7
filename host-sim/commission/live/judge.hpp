#pragma once
// Whether the wire in the servo is the one that its settings describe, as far as resistance, load
// and heat tell. Each function returns what is wrong, as a sentence for a person; empty: nothing.

#include <string>

#include "firmware/prepared.hpp"

namespace smaservo::commission {

/// Least relative fall of the resistance of a wire that transforms. NiTi loses 8 to 20 % between
/// martensite and austenite; temperature alone changes it by less than 2 %, and that upwards.
inline constexpr double least_response = 0.03;
/// Least share of the minimum current that must flow; measurements below half of it do not count in
/// the device either.
inline constexpr double least_current_share = 0.5;

/// Means of current, voltage and stress over a part of a level.
struct Means {
  double current_A, voltage_V, stress_Pa;
  double resistance_ohm() const { return voltage_V / current_A; }
};

std::string judge_load(const Prepared<double>& device, double stress_Pa);
/// Whether there is a resistance at all while at least the minimum current is wanted.
std::string judge_leads(const Prepared<double>& device, const Means& cold);
/// Names the length, and the diameter, that would explain a resistance that differs.
std::string judge_cold(const Prepared<double>& device, const Means& cold, double ambient_K);
/// `limited`: the device's names for what has limited the heat; empty: nothing.
std::string judge_response(const Means& cold, const Means& hot, const std::string& limited);

}  // namespace smaservo::commission
