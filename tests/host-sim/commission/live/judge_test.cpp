#include "host-sim/commission/live/judge.hpp"

#include <gmock/gmock.h>
#include <limits>

#include "tests/can/simulated_servo.hpp"

namespace smaservo::commission {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr double air_K = 298.15;

struct Judge : testing::Test {
  /// At 20 mA.
  static Means at(double ohm) { return {0.02, 0.02 * ohm, 150e6}; }
  double cold_ohm(double stress_Pa) const {
    using Model = Plant<ThreePhase<double>>;
    const auto params = plant_params(device.settings.wire);
    return Model::resistance_ohm(params, Model::rest(params, {air_K, stress_Pa}), air_K);
  }

  Prepared<double> device = prepare(test::SimulatedServo::usual_settings(5));
};

TEST_F(Judge, TakesTheWireOfTheSettings) {
  for (const double stress_Pa : {0., 150e6}) {
    for (const double off : {0.92, 1., 1.08}) {
      EXPECT_THAT(judge_cold(device, at(off * cold_ohm(stress_Pa)), air_K), IsEmpty());
    }
  }
}

// From a stretched wire to one that its load has not stretched yet: 2 % of the resistance.
TEST_F(Judge, NamesTheLengthsThatExplainTheResistance) {
  const double most = std::max(cold_ohm(0), cold_ohm(150e6));
  EXPECT_THAT(judge_cold(device, at(1.2 * most), air_K), HasSubstr("20 % more"));
  EXPECT_THAT(judge_cold(device, at(1.2 * most), air_K),
              HasSubstr("wire.length of 120 to 122 mm instead of 100 mm"));
  const double least = std::min(cold_ohm(0), cold_ohm(150e6));
  EXPECT_THAT(judge_cold(device, at(0.7 * least), air_K), HasSubstr("30 % less"));
  EXPECT_THAT(judge_cold(device, at(0.7 * least), air_K),
              HasSubstr("wire.length of 69 to 70 mm instead of 100 mm"));
}

TEST_F(Judge, FindsLeadsThatAreOff) {
  EXPECT_THAT(judge_leads(device, at(cold_ohm(0))), IsEmpty());
  EXPECT_THAT(judge_leads(device, {0, 5, 150e6}), HasSubstr("open"));
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(judge_leads(device, {nan, nan, nan}), HasSubstr("open"));
  EXPECT_THAT(judge_leads(device, {0.02, 0.001, 150e6}), HasSubstr("sense lead"));
}

TEST_F(Judge, FindsALoadThatIsMissing) {
  EXPECT_THAT(judge_load(device, 150e6), IsEmpty());
  EXPECT_THAT(judge_load(device, 1e6), HasSubstr("the load is missing: the load cell reads"));
  EXPECT_THAT(judge_load(device, std::numeric_limits<double>::quiet_NaN()),
              HasSubstr("no reading"));
  device.settings.measurement.has_load_cell = false;
  EXPECT_THAT(judge_load(device, 0), HasSubstr("measurement.constant_load_N is 0 N"));
}

// Copper rises, a resistor stays, NiTi falls.
TEST_F(Judge, WantsAResistanceThatFalls) {
  EXPECT_THAT(judge_response(at(20), at(17.5), ""), IsEmpty());
  EXPECT_THAT(judge_response(at(20), at(20), ""), HasSubstr("does not transform"));
  EXPECT_THAT(judge_response(at(20), at(24), ""), HasSubstr("rises by 20.0 %"));
  EXPECT_THAT(judge_response(at(20), at(19.8), "supply"), HasSubstr("(limited by supply)"));
}

}  // namespace
}  // namespace smaservo::commission
