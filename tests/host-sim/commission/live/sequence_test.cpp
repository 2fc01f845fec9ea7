#include "host-sim/commission/live/sequence.hpp"

#include <gmock/gmock.h>

#include "firmware/text/settings_file.hpp"
#include "model/files/error.hpp"
#include "model/files/wire/wire_file.hpp"
#include "tests/can/simulated_servo.hpp"

namespace smaservo::commission {
namespace {

using ::testing::HasSubstr;

constexpr SequenceInputs usual{150e6, 298.15, 22};

Settings<double> usual_settings() {
  return test::SimulatedServo::usual_settings(5);
}

Sequence planned(const Settings<double>& settings, std::size_t questions = 1) {
  return plan_sequence(prepare(settings), usual, {}, questions);
}

std::string refusal(const Settings<double>& settings) {
  try {
    planned(settings);
  } catch (const files::UserError& error) {
    return error.what();
  }
  return "";
}

TEST(Sequence, StaysBelowThreeMinutesWithAllQuestions) {
  const Sequence sequence = planned(usual_settings(), most_questions);
  EXPECT_NEAR(sequence.seconds(), 84, 1e-9);
  EXPECT_EQ(std::ranges::count_if(sequence.levels, &Level::asks), most_questions);
  EXPECT_LT(sequence.seconds() + most_questions * 20, 180);
  EXPECT_EQ(std::ranges::count_if(planned(usual_settings(), 0).levels, &Level::asks), 0);
}

// Nothing is known of the wire in the first cycle.
TEST(Sequence, FirstCycleHasAtMostSeventyPercentOfTheCurrent) {
  Settings<double> settings = usual_settings();
  for (const double current_A : {0.14, 0.2, 0.4}) {
    settings.limits.current_A = current_A;
    for (const Level& level : planned(settings).levels) {
      // A wire that has transformed has at least 0.85 of its cold resistance.
      const double most_A = std::sqrt(level.power_W / (0.85 * usual.cold_ohm));
      EXPECT_LE(most_A, (level.kind == LevelKind::first ? 0.7 : 1) * current_A * (1 + 1e-9));
    }
  }
}

// By the wire of the settings, the staircases pass through the whole transformation, both ways.
TEST(Sequence, PassesThroughTheWholeTransformation) {
  const auto device = prepare(usual_settings());
  const Span span = span_of(device, usual.stress_Pa);
  const auto& body = device.observer.model.body;
  const auto holds = [&](double kelvin) { return body.loss_W(kelvin - usual.ambient_K); };
  for (const unsigned cycle : {2U, 3U}) {
    double least_up = 1e9, most = 0, least_down = 1e9;
    for (const Level& level : planned(usual_settings()).levels) {
      if (level.cycle == cycle) {
        double& least = level.kind == LevelKind::up ? least_up : least_down;
        least = std::min(least, level.power_W);
        most = std::max(most, level.power_W);
      }
    }
    EXPECT_LT(least_up, holds(span.heating_start_K));
    EXPECT_GT(most, holds(span.heating_finish_K));
    EXPECT_LT(least_down, holds(span.cooling_finish_K));
    // The resistance is measurable there: at least a tenth of the current.
    EXPECT_GE(least_down, 0.01 * most);
  }
  EXPECT_TRUE(planned(usual_settings()).whole);
}

TEST(Sequence, StaysBelowTheLimitOfTheTemperature) {
  Settings<double> settings = usual_settings();
  const double allowed_K = settings.limits.temperature_K - settings.limits.hot_spot_K;
  EXPECT_LT(planned(settings).top_K, allowed_K);
  settings.limits.temperature_K -= 4;
  EXPECT_FALSE(planned(settings).whole);
  settings.limits.temperature_K -= 20;
  EXPECT_THAT(refusal(settings), HasSubstr("limits.temperature_K of 369 K"));
}

// The maker's current of SmartFlex, which only holds 70 degC, moves nothing.
TEST(Sequence, IsRefusedWhereTheCurrentIsTooSmall) {
  const Settings<double> settings = text::settings_for(files::load_wire("smartflex-76um").wire);
  EXPECT_THAT(refusal(settings), HasSubstr("limits.current_A of 0.092 A"));
  EXPECT_THAT(refusal(settings), HasSubstr("SAFETY.md"));
}

// What the makers of Flexinol state suffices.
TEST(Sequence, TakesTheMakersCurrentOfFlexinol) {
  for (const char* const wire : {"flexinol-lt-0.15mm", "flexinol-lt-0.25mm"}) {
    const Settings<double> settings = text::settings_for(files::load_wire(wire).wire);
    const auto device = prepare(settings);
    EXPECT_NO_THROW(plan_sequence(device, {100e6, 298.15, device.cold_ohm}, {}, 1)) << wire;
  }
}

TEST(Sequence, SaysWhereItIs) {
  const Sequence sequence = planned(usual_settings());
  EXPECT_EQ(level_text(sequence, 0), "at rest");
  EXPECT_EQ(level_text(sequence, 1), "cycle 1 of 3, level 1 of 2");
  EXPECT_EQ(level_text(sequence, 3), "cycle 2 of 3, level 1 of 13");
  EXPECT_EQ(level_text(sequence, sequence.levels.size() - 1), "cycle 3 of 3, level 13 of 13");
}

}  // namespace
}  // namespace smaservo::commission
