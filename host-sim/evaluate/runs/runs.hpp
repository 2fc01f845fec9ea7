#pragma once
// The runs by which observers are judged: those with which a unit is calibrated, and those with
// which it is tested, in conditions that the calibration has not seen.

#include <array>
#include <cstdint>
#include <string_view>

#include "firmware/bench/scenario/scenario.hpp"
#include "firmware/bench/scenario/units.hpp"

namespace smaservo::evaluate {

inline constexpr double MPa = 1e6;

inline constexpr std::array calibration_stresses_MPa{10.0,  25.0,  50.0,  100.0,
                                                     150.0, 200.0, 300.0, 400.0};

/// 60 s at 1 kHz under one of calibration_stresses_MPa: at rest at 25 °C, two full cycles, ten
/// shrinking loops, random steps of the power.
bench::Scenario calibration_run(const bench::WireUnit& unit, std::size_t index);

/// With which a unit is commissioned: 86 s at 1 kHz under a constant load of 120 to 250 MPa. The
/// cold wire rests for 2 s, is heated with 70 % of the current for 5 s, rests for 5 s, and then
/// climbs and descends two staircases of seven and six levels.
bench::Scenario commissioning_run(const bench::WireUnit& unit);
/// When in that run the wire's length is read: cold at rest, and at the top of the first staircase.
inline constexpr std::array commissioning_readings_s{1.8, 32.8};

enum class Condition : unsigned char {
  constant,       ///< 100..400 MPa
  spring,         ///< a bias spring, 100..300 MPa
  varying,        ///< a load that oscillates and drifts, 100..300 MPa
  light,          ///< 10..50 MPa
  unknown_start,  ///< recorded from the middle of a motion on, 50..400 MPa
  /// Held in mid-transformation for 20 s, power +-50 % at 2 Hz; weight or spring.
  hold_ripple,
  /// Held in mid-transformation; for 10 s the air cools 0.5 to 3 times as much. Weight or spring.
  gust,
  coarse  ///< constant load, measured by converters of 12 bits at 100 Hz
};
inline constexpr std::array all_conditions{
    Condition::constant,      Condition::spring,      Condition::varying, Condition::light,
    Condition::unknown_start, Condition::hold_ripple, Condition::gust,    Condition::coarse};
std::string_view condition_name(Condition condition);

/// 40 to 60 s, at 1 kHz and with 16 bits unless the condition gives other values. The load cell has
/// an error of up to 0.5 %. Disturbed: the ambient temperature is off by up to 10 K, convection by
/// up to 20 %, the resistance by 1 % up or down, the load cell by up to 1 %; the power is adjusted
/// so that the wire still transforms completely. All random numbers come from the seed.
bench::Scenario test_run(const bench::WireUnit& unit, Condition condition, std::uint64_t seed,
                         bool disturbed = false);

}  // namespace smaservo::evaluate
