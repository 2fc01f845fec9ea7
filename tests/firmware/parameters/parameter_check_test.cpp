#include "firmware/parameters/parameter_check.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <string>

#include "tests/firmware/device/test_device.hpp"
#include "tests/firmware/parameters/random_settings.hpp"

namespace smaservo::parameter_check_test {
namespace {

using Rows = std::pair<std::string, std::string>;

void set(Settings<double>& settings, std::string_view path, double value) {
  const Parameter<double>& row = parameters<double>[find_parameter(path)];
  row.set(settings, row.type == ValueType::real ? Value::real(static_cast<float>(value))
                                                : Value::number(static_cast<std::uint32_t>(value)));
}

std::string name(std::size_t i) {
  return i < parameter_count ? std::string(parameters<double>[i].path.text()) : "";
}

TEST(ParameterCheck, DefaultsDoWithEveryPresetWire) {
  EXPECT_TRUE(check(default_settings<double>()).ok());
  for (const std::string& wire : files::preset_names()) {
    const Finding f = check(reference_settings(wire.c_str()));
    EXPECT_TRUE(f.ok()) << wire << ": " << name(f.parameter) << " " << name(f.other);
    EXPECT_EQ(first_missing(reference_settings(wire.c_str())), no_parameter) << wire;
  }
}

TEST(ParameterCheck, TheSettingsOfTheTestsPass) {
  const Finding f = check(test_settings());
  EXPECT_TRUE(f.ok()) << name(f.parameter) << " " << name(f.other);
}

TEST(ParameterCheck, ADeviceWithoutWireIsNotConfigured) {
  EXPECT_EQ(name(first_missing(default_settings<double>())), "wire.length_m");
  Settings<double> settings = reference_settings();
  settings.wire.kinetics.a2m_a2r.turning[1] = Pair<double>(0, std::nan(""));
  EXPECT_EQ(name(first_missing(settings)), "wire.a2r.turning_1_1_Pa");
  settings = reference_settings();
  settings.wire.kinetics.r2a.start_K[0] = std::nan("");
  EXPECT_EQ(first_missing(settings), no_parameter) << "it shares m2a's surface";
  settings.wire.kinetics.separate_r2a = true;
  EXPECT_EQ(name(first_missing(settings)), "wire.r2a.start_0_K");
}

TEST(ParameterCheck, EveryValueOutsideOfItsRangeIsNamed) {
  Settings<double> both = reference_settings();
  both.wire.kinetics.separate_r2a = both.wire.kinetics.separate_r2m = true;
  both.wire.kinetics.r2a = both.wire.kinetics.m2a;
  both.wire.kinetics.r2m = first_surface(both.wire.kinetics.a2m_a2r);
  ASSERT_TRUE(check(both).ok());
  for (std::size_t i = 0; i < parameter_count; ++i) {
    const Parameter<double>& row = parameters<double>[i];
    if (row.type != ValueType::real) {
      continue;
    }
    const float inf = std::numeric_limits<float>::infinity();
    const std::pair<float, Problem> bad[] = {{std::nextafter(row.min.real(), -inf), Problem::below},
                                             {std::nextafter(row.max.real(), inf), Problem::above},
                                             {inf, Problem::not_finite}};
    for (const auto& [value, problem] : bad) {
      Settings<double> settings = both;
      row.set(settings, Value::real(value));
      const Finding f = check(settings);
      EXPECT_EQ(f.problem, problem) << row.path.text();
      EXPECT_EQ(f.parameter, i) << row.path.text();
    }
  }
}

TEST(ParameterCheck, ContradictionsNameBothParameters) {
  struct Case {
    const char* path;
    double value;
    const char* other;
  };
  const Case cases[] = {
      {"timing.command_timeout_s", 0.0019, "timing.period_s"},
      {"timing.period_s", 0.02, "timing.sample_timeout_s"},
      {"strain.tracking_s", 0.0005, "timing.period_s"},
      {"limits.min_current_A", 0.1, "limits.current_A"},
      {"limits.current_A", 0.15, "trips.current_A"},
      {"trips.current_A", 0.5, "measurement.current_full_scale_A"},
      {"trips.current_offset_A", 0.01, "limits.min_current_A"},
      {"limits.temperature_K", 403.15, "trips.temperature_K"},
      {"wire.limits.temperature_K", 390, "limits.temperature_K"},
      {"limits.hot_spot_K", 50, ""},  // contradicts the surface of m2a, see below
      {"trips.max_ambient_K", 393.15, "limits.temperature_K"},
      {"trips.min_ambient_K", 340, "trips.max_ambient_K"},
      {"limits.min_strain", 0.05, "limits.max_strain"},
      {"trips.min_strain", 0, "limits.min_strain"},
      {"trips.max_strain", 0.05, "limits.max_strain"},
      {"axis.zero_strain", 0.051, "limits.max_strain"},
      {"axis.zero_strain", -0.001, "limits.min_strain"},
      {"limits.stress_Pa", 200e6, "trips.stress_Pa"},
      {"wire.limits.stress_Pa", 140e6, "limits.stress_Pa"},
      {"trips.slack_Pa", 150e6, "limits.stress_Pa"},
      {"drive.min_supply_V", 30, "drive.max_supply_V"},
      {"profile.loop_s", 5, "profile.cycle_s"},
      {"wire.heat.latent_r2a_J_kg", 21e3, "wire.heat.latent_m2a_J_kg"},
      {"wire.m2a.finish_0_K", 345, "wire.m2a.start_0_K"},
      {"wire.a2m.finish_0_K", 316, "wire.a2m.start_0_K"},
      {"wire.a2r.start_1_K_Pa", -1e-8, "wire.a2r.finish_0_K"},
      {"wire.a2r.start_2_K_Pa2", 1e-13, ""},
      {"wire.a2m.curvature_1_1_Pa", -1e-7, "wire.a2m.curvature_0"},
      {"wire.m2a.turning_1_1_Pa", 1e-9, "wire.m2a.turning_0"},
  };
  for (const Case& c : cases) {
    Settings<double> settings = reference_settings();
    set(settings, c.path, c.value);
    const Finding f = check(settings);
    EXPECT_EQ(f.problem, Problem::contradiction) << c.path;
    if (*c.other != '\0') {
      const Rows found{name(f.parameter), name(f.other)};
      EXPECT_TRUE(found == Rows(c.path, c.other) || found == Rows(c.other, c.path) ||
                  found.first == c.other || found.second == c.other)
          << c.path << ": " << found.first << ", " << found.second;
      EXPECT_FALSE(parameter_rules[f.rule].meaning.empty());
    }
  }
}

/// What holds the wire at its limit is computed here by hand from the
/// settings' own heat loss.
TEST(ParameterCheck, TheMinimumCurrentHeatsNoMoreThanTheLimitsAllow) {
  Settings<double> s = reference_settings();
  const double ohm = cold_resistance_ohm(s.wire);
  const auto idle_W = [&] { return s.limits.min_current_A * s.limits.min_current_A * ohm; };
  const auto problem = [&] { return check(s).problem; };
  ASSERT_EQ(problem(), Problem::none);
  s.limits.power_W = idle_W() * 0.999;
  EXPECT_EQ(problem(), Problem::contradiction) << "the power while arming is more than allowed";
  s.limits.power_W = idle_W() * 1.001;
  EXPECT_EQ(problem(), Problem::none);
  s.limits.power_W = 100;
  const double held_W = thermal_body(s.wire.geometry, s.wire.heat)
                            .loss_W(s.limits.temperature_K - s.limits.hot_spot_K - room_K);
  s.limits.min_current_A = std::sqrt(0.0999 * held_W / ohm);
  ASSERT_LT(s.limits.min_current_A, s.limits.current_A);
  EXPECT_EQ(problem(), Problem::none);
  s.limits.min_current_A = std::sqrt(0.1001 * held_W / ohm);
  EXPECT_EQ(problem(), Problem::contradiction);
}

/// Of every rule, both sides of its limit.
TEST(ParameterCheck, ARuleHoldsUpToItsLimitAndNoFurther) {
  for (const Rule& rule : parameter_rules) {
    const Parameter<double>& a = parameters<double>[rule.a];
    const Parameter<double>& b = parameters<double>[rule.b];
    if (rule.relation != Relation::below && rule.relation != Relation::not_above) {
      continue;
    }
    Settings<double> settings = reference_settings();
    EXPECT_TRUE(holds(rule, settings));
    const float plus =
        rule.plus < parameter_count ? parameters<double>[rule.plus].get(settings).real() : 0;
    const float limit = rule.factor * a.get(settings).real() + plus;
    const float inf = std::numeric_limits<float>::infinity();
    b.set(settings, Value::real(limit));
    EXPECT_EQ(holds(rule, settings), rule.relation == Relation::not_above) << a.path.text();
    b.set(settings, Value::real(std::nextafter(limit, inf)));
    EXPECT_TRUE(holds(rule, settings)) << a.path.text();
    b.set(settings, Value::real(std::nextafter(limit, -inf)));
    EXPECT_FALSE(holds(rule, settings)) << a.path.text();
  }
}

TEST(ParameterCheck, TemperatureLimitLeavesRoomForTheTransformation) {
  Settings<double> settings = reference_settings();
  set(settings, "limits.hot_spot_K", 50);
  const Finding f = check(settings);
  EXPECT_EQ(name(f.parameter), "wire.m2a.start_0_K");
  EXPECT_EQ(name(f.other), "limits.temperature_K");
}

TEST(ParameterCheck, RandomSettingsDifferAndPass) {
  std::mt19937 random(5);
  std::size_t changed = 0;
  for (int i = 0; i < 20; ++i) {
    const Settings<double> settings = random_settings(random);
    EXPECT_TRUE(check(settings).ok());
    const Settings<double> reference = reference_settings();
    for (const Parameter<double>& row : parameters<double>) {
      changed += row.get(settings) != row.get(reference) ? 1U : 0U;
    }
  }
  EXPECT_GT(changed, 20U * 100U);
}

}  // namespace
}  // namespace smaservo::parameter_check_test
