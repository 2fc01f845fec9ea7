#include "firmware/text/settings_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "model/files/error.hpp"
#include "tests/firmware/parameters/random_settings.hpp"
#include "tests/hal/replay/temporary_folder.hpp"

namespace smaservo::test {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

constexpr std::string_view with_wire = "[wire]\nbased_on = \"smartflex-76um\"\n";

Settings<double> parse(const std::string& text,
                       const std::vector<files::Override>& overrides = {}) {
  return text::parse_settings_file(text, "device.toml", overrides);
}

std::string error_of(const std::string& text, const std::vector<files::Override>& overrides = {}) {
  try {
    parse(text, overrides);
  } catch (const files::UserError& error) {
    return error.what();
  }
  ADD_FAILURE() << "it is accepted:\n" << text;
  return "";
}

/// An error in the last line of this text, after a wire of two lines.
std::string error_in(const std::string& table, const std::string& line) {
  return error_of(std::string(with_wire) + "[" + table + "]\n" + line + "\n");
}

TEST(SettingsFile, AWireIsEnough) {
  EXPECT_TRUE(same_settings(parse(std::string(with_wire)), reference_settings()));
  EXPECT_TRUE(same_settings(parse("wire = \"smartflex-76um\""), reference_settings()));
}

TEST(SettingsFile, ReadsBackWhatItWrites) {
  std::mt19937 random(21);
  for (int i = 0; i < 100; ++i) {
    const Settings<double> settings = random_settings(random);
    EXPECT_TRUE(same_settings(parse(text::to_toml(settings)), settings));
  }
  Settings<double> own = reference_settings();
  own.wire.kinetics.separate_r2a = own.wire.kinetics.separate_r2m = true;
  own.wire.kinetics.r2a = own.wire.kinetics.m2a;
  own.wire.kinetics.r2m = first_surface(own.wire.kinetics.a2m_a2r);
  EXPECT_TRUE(same_settings(parse(text::to_toml(own)), own));
}

TEST(SettingsFile, TheTemplateOfEveryPresetIsAFile) {
  for (const std::string& wire : files::preset_names()) {
    const Settings<double> settings = parse(text::settings_template(wire));
    EXPECT_TRUE(same_settings(settings, text::settings_for(files::load_wire(wire).wire))) << wire;
    EXPECT_EQ(static_cast<float>(settings.limits.current_A),
              static_cast<float>(files::load_wire(wire).wire.limits.current_A));
  }
}

TEST(SettingsFile, UnitsMayBeAnyOfTheirKind) {
  const Settings<double> settings = parse(
      "limits.temperature_degC = 110\nlimits.current_mA = 120\ntiming.command_timeout_ms = 50\n"
      "limits.stress_MPa = 120\nlimits.max_strain_percent = 4.5\nwire.length_mm = 182\n"
      "wire.based_on = \"smartflex-76um\"\nwire.m2a.start_1_K_MPa = 0.13\n");
  EXPECT_EQ(settings.limits.temperature_K, static_cast<double>(383.15F));
  EXPECT_EQ(settings.limits.current_A, static_cast<double>(0.12F));
  EXPECT_EQ(settings.timing.command_timeout_s, static_cast<double>(0.05F));
  EXPECT_EQ(settings.limits.stress_Pa, 120e6);
  EXPECT_EQ(settings.limits.max_strain, static_cast<double>(0.045F));
  EXPECT_EQ(settings.wire.geometry.length_m, static_cast<double>(0.182F));
  EXPECT_EQ(settings.wire.kinetics.m2a.start_K[1], static_cast<double>(0.13e-6F));
}

TEST(SettingsFile, OverridesComeLast) {
  const Settings<double> settings =
      parse(std::string(with_wire) + "[limits]\ncurrent_A = 0.11\n",
            {{"limits.current_mA", "120"}, {"safe.state", "hold"}, {"wire", "smartflex-100um"}});
  EXPECT_EQ(settings.limits.current_A, static_cast<double>(0.12F));
  EXPECT_EQ(settings.safe.state, SafeState::hold);
  EXPECT_EQ(settings.wire.geometry.diameter_m, static_cast<double>(100e-6F));
  EXPECT_EQ(error_of(std::string(with_wire), {{"limits.current_mA", "0"}}),
            "--set: limits.current_mA = 0: must be between 1 and 20000 mA, is 0");
}

TEST(SettingsFile, AWireFileStandsBesideIt) {
  const TemporaryFolder folder;
  folder.write("gripper.toml", "based_on = \"smartflex-76um\"\nwire.length_mm = 182\n");
  const std::string file = folder.write("device.toml", "wire = \"gripper.toml\"\n");
  EXPECT_EQ(text::load_settings_file(file).wire.geometry.length_m, static_cast<double>(0.182F));
  EXPECT_THROW(text::load_settings_file(folder / "nothing.toml"), files::UserError);
}

TEST(SettingsFile, MistakesSayWhereAndWhatIsAllowed) {
  EXPECT_EQ(error_in("limits", "current_A = 30"),
            "device.toml:4: limits.current_A = 30: must be between 0.001 and 20 A, is 30");
  EXPECT_EQ(
      error_in("limits", "temperature_degC = 500"),
      "device.toml:4: limits.temperature_degC = 500: must be between 0 and 326.85 degC, is 500");
  EXPECT_EQ(error_in("limits", "current = 0.1"),
            "device.toml:4: limits.current = 0.1: unknown key or unit; allowed: current_A, "
            "current_mA");
  EXPECT_THAT(error_in("limits", "current_kA = 0.1"), HasSubstr("allowed: current_A, current_mA"));
  EXPECT_THAT(error_in("limits", "colour = 1"), HasSubstr("[limits] has: min_current_A,"));
  EXPECT_THAT(error_in("colours", "red = 1"), HasSubstr("the tables are: identity, timing,"));
  EXPECT_THAT(error_of("red = 1"), StartsWith("device.toml:1: red = 1: unknown table"));
  for (const char* bad : {"nan", "inf", "-inf", "\"0.1\"", "true", "[0.1]"}) {
    EXPECT_THAT(error_in("limits", std::string("current_A = ") + bad),
                HasSubstr("must be a finite number"));
  }
  EXPECT_THAT(error_in("limits", "current_A = 1e300"), HasSubstr("must be between"));
  EXPECT_EQ(error_in("identity", "node_id = 128"),
            "device.toml:4: identity.node_id = 128: must be a whole number, 1 to 127");
  EXPECT_THAT(error_in("identity", "node_id = 1.5"), HasSubstr("whole number"));
  EXPECT_EQ(error_in("safe", "state = \"sleep\""),
            "device.toml:4: safe.state = 'sleep': must be one of: off, hold, release");
  EXPECT_THAT(error_in("measurement", "has_load_cell = 1"), HasSubstr("must be true or false"));
  EXPECT_THAT(error_in("limits", "current_A = 0.1\ncurrent_mA = 100"),
              HasSubstr("is given twice, first by device.toml:4: limits.current_A = 0.1"));
  EXPECT_THAT(error_in("limits", "current_A = "), StartsWith("device.toml:4"));
}

TEST(SettingsFile, AWireIsNeeded) {
  EXPECT_EQ(error_of(""),
            "device.toml: wire.length is missing; [wire] needs based_on = \"PRESET or "
            "FILE.toml\", or every number of the wire");
  EXPECT_THAT(error_of("[wire]\nlength_m = 0.1"), HasSubstr("wire.diameter is missing"));
  EXPECT_THAT(error_of("wire = \"copper\""),
              StartsWith("device.toml:1: wire = 'copper': copper: no such wire"));
  EXPECT_THAT(error_of("wire = 3"), HasSubstr("must be a string: a preset or a wire file"));
  EXPECT_THAT(error_of(std::string(with_wire) + "separate_r2a = true"),
              HasSubstr("wire.r2a needs all of start, finish, curvature and turning"));
}

/// [wire] may have every key of a wire file; a number that it replaces changes no other one.
TEST(SettingsFile, TheWireIsSaidAsInAWireFile) {
  const Wire<double> preset = files::load_wire("smartflex-76um").wire;
  const Wire<double> wire = parse(std::string(with_wire) +
                                  "diameter_um = 80\n[wire.m2a]\nstart_degC_by_MPa = [70, 0.12]\n"
                                  "[wire.austenite]\nresistivity_uohm_m = 0.9\n")
                                .wire;
  const auto kept = [](double x) { return static_cast<double>(static_cast<float>(x)); };
  EXPECT_EQ(wire.kinetics.m2a.start_K[0], kept(343.15));
  EXPECT_EQ(wire.kinetics.m2a.start_K[1], kept(0.12e-6));
  EXPECT_EQ(wire.kinetics.m2a.start_K[2], 0);
  EXPECT_EQ(wire.limits.stress_Pa, kept(preset.limits.stress_Pa));
  EXPECT_EQ(wire.heat.convection_W_m2K, kept(preset.heat.convection_W_m2K));
  EXPECT_EQ(wire.material.austenite.resistivity_ohm_m_K,
            kept(preset.material.austenite.resistivity_ohm_m_K));
  const Wire<double> light = parse(std::string(with_wire) + "[wire.limits]\nload_N = 2.2\n").wire;
  EXPECT_EQ(light.limits.stress_Pa, kept(2.2 / preset.geometry.area_m2()));
}

TEST(SettingsFile, OldKeysSayWhatTheyAreCalledNow) {
  EXPECT_EQ(error_in("measuring", "load_gain = 1"),
            "device.toml:4: measuring.load_gain = 1: is now called measurement.load_gain");
  EXPECT_EQ(error_in("wire.heat", "convection_W_m2K2 = 1"),
            "device.toml:4: wire.heat.convection_W_m2K2 = 1: is now called "
            "wire.heat.convection_slope_W_m2K2");
  EXPECT_EQ(error_in("observer", "loss_sd = 0.2"),
            "device.toml:4: observer.loss_sd = 0.2: is now called observer.start_loss_sd");
  EXPECT_EQ(error_of(std::string(with_wire), {{"observer.ambient_sd_K", "5"}}),
            "--set: observer.ambient_sd_K = 5: is now called observer.start_ambient_sd_K");
  EXPECT_EQ(error_of(std::string(with_wire), {{"measuring.load_gain", "1"}}),
            "--set: measuring.load_gain = 1: is now called measurement.load_gain");
  // The table [limits] is the device's, and does not have the keys of a wire's limits.
  EXPECT_THAT(error_in("limits", "load_N = 2"), HasSubstr("unknown key; [limits] has: "));
}

TEST(SettingsFile, ContradictionsNameBothKeysWithTheirPlaces) {
  EXPECT_EQ(error_in("limits", "current_A = 0.2\n[trips]\ncurrent_mA = 180"),
            "device.toml:4: limits.current_A = 0.2: limits.current_A must be below "
            "trips.current_A: the limit must act before the trip; device.toml:6: "
            "trips.current_mA = 180");
  EXPECT_THAT(error_in("limits", "current_A = 0.2"),
              HasSubstr("device.toml: trips.current_A = 0.15 (default)"));
  EXPECT_THAT(error_in("limits", "temperature_degC = 151\n[trips]\ntemperature_degC = 160"),
              HasSubstr("wire.limits.temperature_K = 423.15 (smartflex-76um)"));
  EXPECT_THAT(error_in("timing", "command_timeout_ms = 1.5"),
              HasSubstr("2 timing.period_s must not be above timing.command_timeout_s"));
  EXPECT_THAT(error_of(std::string(with_wire) + "m2a.finish_0_degC = 70\n"),
              HasSubstr("finish at least 1 K above start"));
}

}  // namespace
}  // namespace smaservo::test
