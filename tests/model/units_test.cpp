#include "model/units.hpp"

#include <gtest/gtest.h>

namespace smaservo::units_test {
namespace {

double si(std::string_view name, std::string_view base, Kind kind, double value) {
  const auto unit = unit_of(name, base, kind);
  return unit ? unit->to_si(value) : -1e300;
}

TEST(Units, SuffixDecidesTheFactor) {
  EXPECT_DOUBLE_EQ(si("temperature_degC", "temperature", kind::temperature, 25), 298.15);
  EXPECT_DOUBLE_EQ(si("temperature_K", "temperature", kind::temperature, 25), 25);
  EXPECT_DOUBLE_EQ(si("stress_MPa", "stress", kind::stress, 3), 3e6);
  EXPECT_DOUBLE_EQ(si("current_mA", "current", kind::current, 92), 0.092);
  EXPECT_DOUBLE_EQ(si("load_gf", "load", kind::force, 1000), 9.80665);
  EXPECT_DOUBLE_EQ(si("resistivity_uohm_cm", "resistivity", kind::resistivity, 100), 1e-6);
  EXPECT_DOUBLE_EQ(si("strain", "strain", kind::number, 0.04), 0.04);
  EXPECT_DOUBLE_EQ(si("strain_percent", "strain", kind::number, 4), 0.04);
}

TEST(Units, OtherNamesAndUnitsAreNotTaken) {
  EXPECT_FALSE(unit_of("temperature", "temperature", kind::temperature));
  EXPECT_FALSE(unit_of("temperature_degF", "temperature", kind::temperature));
  EXPECT_FALSE(unit_of("temperature_K_", "temperature", kind::temperature));
  EXPECT_FALSE(unit_of("temperatureK", "temperature", kind::temperature));
  EXPECT_FALSE(unit_of("temperature_ref_K", "temperature", kind::temperature));
  EXPECT_FALSE(unit_of("ambient_K", "temperature", kind::temperature));
  EXPECT_FALSE(unit_of("strain_", "strains", kind::number));
}

TEST(Units, ThereAndBackIsTheSameValue) {
  for (const Kind& k : {Kind(kind::temperature), Kind(kind::force), Kind(kind::stress),
                        Kind(kind::resistivity), Kind(kind::specific_energy)}) {
    EXPECT_EQ(k.front().to_si(7), 7) << "the first unit of a kind is SI's own";
    for (const Unit& unit : k) {
      EXPECT_NEAR(unit.from_si(unit.to_si(12.5)), 12.5, 1e-12) << unit.suffix;
    }
  }
}

}  // namespace
}  // namespace smaservo::units_test
