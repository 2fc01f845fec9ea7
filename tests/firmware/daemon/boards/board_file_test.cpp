#include "firmware/daemon/boards/board_file.hpp"

#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <sstream>

#include "firmware/text/settings_file.hpp"
#include "model/files/error.hpp"
#include "tests/hal/replay/temporary_folder.hpp"
#include "tests/places.hpp"

namespace smaservo::test::board_file_test {
namespace {

const std::string& boards() {
  static const std::string folder = test::source_folder() + "/hal/linux/boards";
  return folder;
}

TEST(BoardFile, TheExamplesAreWhole) {
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(boards())) {
    if (!entry.is_regular_file()) {
      continue;
    }
    const daemon::BoardFile file = daemon::load_board_file(entry.path());
    EXPECT_FALSE(file.name.empty());
    const Settings<double> settings = text::load_settings_file(file.device);
    EXPECT_EQ(daemon::board_problem(file, settings), "") << entry.path();
    ++count;
  }
  EXPECT_GE(count, 2);
}

TEST(BoardFile, CodesMeanWhatTheConvertersDataSheetSays) {
  const daemon::BoardFile file = daemon::load_board_file(boards() + "/reference.toml");
  // A full-scale code of 2^23 is 1.2 V at the pins, by gain.
  const hal::Channel& current = file.calibration.current;
  EXPECT_NEAR(current.scale * 0x1p23, 1.2 / 1.0, 1e-12);
  EXPECT_EQ(file.thread.priority, 80);
  EXPECT_EQ(file.lines.kick.name, "smaservo-kick");
  EXPECT_NEAR((20'000 + file.slow[hal::SlowSensors::ambient].offset) *
                  file.slow[hal::SlowSensors::ambient].scale,
              293.15, 1e-9);
}

/// What is said of an example with one line changed.
std::string refusal(const std::string& from, const std::string& to,
                    const std::string& board = "/reference.toml") {
  const TemporaryFolder folder;
  std::string text = file_text(boards() + board);
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  text.replace(at, from.size(), to);
  const std::string path = folder / "board.toml";
  std::ofstream(path) << text;
  try {
    daemon::load_board_file(path);
  } catch (const files::UserError& error) {
    return error.what();
  }
  return "";
}

TEST(BoardFile, AMistakeNamesFileKeyValueAndRange) {
  struct Case {
    const char *from, *to, *says;
  };
  const Case cases[] = {
      {"priority = 80", "priority = 99", "loop.priority = 99: must be a number between 1 and 98"},
      {"priority = 80", "priority = 80.5", "loop.priority = 80.5: must be a whole number"},
      {"oversampling = 1024", "oversampling = 1000", "front_end.oversampling = 1000"},
      {"channel = 0", "channel = 4", "front_end.current.channel = 4"},
      {"per_volt = 1.0", "per_volt = 0", "per_volt = 0: must not be zero"},
      {"type = \"spi-dac\"", "type = \"dac\"", "must be one of: iio-dac, spi-dac, pwm"},
      {"max_mA", "max_A", "drive.max_mA: is missing"},
      {"max_mA", "greatest_mA", "drive.greatest_mA = 500: is now called max_mA"},
      {"[lines.kick]", "[lines.kock]", "lines.kock"},
      {"[lines.kick]", "[ceilings]\ncurrent_A = 1\n[lines.kick]",
       "ceilings.current_A = 1: unknown key (did you mean current_mA or trip_current_mA?); "
       "allowed: current_mA"},
      {"[lines.kick]", "[ceilings]\npower_W = 0\n[lines.kick]", "ceilings.power_W = 0: must be"},
  };
  for (const Case& c : cases) {
    const std::string said = refusal(c.from, c.to);
    EXPECT_NE(said.find(c.says), std::string::npos) << c.to << ": " << said;
    EXPECT_NE(said.find("board.toml:"), std::string::npos) << said;
  }
}

/// The words after `begin`, up to the end of the line, with commas between them.
std::vector<std::string> listed_after(const std::string& text, const std::string& begin) {
  const std::size_t at = text.find(begin);
  EXPECT_NE(at, std::string::npos) << text;
  std::istringstream rest(at == std::string::npos ? "" : text.substr(at + begin.size()));
  std::vector<std::string> words;
  for (std::string word; rest >> word;) {
    words.push_back(word.substr(0, word.find(',')));
  }
  return words;
}

/// The types of front ends and output stages, and the keys of those that the examples have.
TEST(BoardFile, TheReadmeHasEveryTypeAndKey) {
  const std::string readme = file_text(test::source_folder() + "/firmware/daemon/README.md");
  const auto check = [&](const std::string& said, const std::string& begin) {
    const std::vector<std::string> words = listed_after(said, begin);
    EXPECT_GE(words.size(), 2U) << said;
    for (const std::string& word : words) {
      EXPECT_NE(readme.find(word + '`'), std::string::npos)
          << "firmware/daemon/README.md does not know " << word;
    }
  };
  check(refusal("type = \"ads131m04\"", "type = \"\""), "must be one of: ");
  check(refusal("type = \"spi-dac\"", "type = \"\""), "must be one of: ");
  for (const auto& entry : std::filesystem::directory_iterator(boards())) {
    for (const char* const table : {"[front_end]\n", "[drive]\n"}) {
      if (entry.is_regular_file()) {
        const std::string board = "/" + entry.path().filename().string();
        check(refusal(table, table + std::string("no_key = 1\n"), board), "allowed: ");
      }
    }
  }
}

TEST(BoardFile, SettingsBeyondTheBoardAreFound) {
  const daemon::BoardFile file = daemon::load_board_file(boards() + "/reference.toml");
  const Settings<double> good = text::load_settings_file(file.device);
  ASSERT_EQ(daemon::board_problem(file, good), "");
  Settings<double> settings = good;
  settings.limits.current_A = 1;
  EXPECT_EQ(daemon::board_problem(file, settings),
            "limits.current_A = 1: must not be above the board's ceiling, 0.5");
  settings = good;
  settings.drive.kind = DriveKind::voltage;
  EXPECT_EQ(daemon::board_problem(file, settings),
            "drive.kind = voltage: must be current, which the board's drive takes");
}

/// The reference board with more lines at its end.
daemon::BoardFile reference_with(const std::string& lines) {
  const TemporaryFolder folder;
  const std::string path = folder / "board.toml";
  std::ofstream(path) << file_text(boards() + "/reference.toml") << lines;
  return daemon::load_board_file(path);
}

TEST(BoardFile, CeilingsAreThoseOfTheFile) {
  const float none = canopen::Ceilings::none;
  const canopen::Ceilings hardware = reference_with("").ceilings;
  EXPECT_EQ(hardware.current_A, 0.5F) << "of the drive";
  for (const float other :
       {hardware.power_W, hardware.temperature_K, hardware.stress_Pa, hardware.trip_current_A,
        hardware.trip_temperature_K, hardware.trip_stress_Pa}) {
    EXPECT_EQ(other, none);
  }
  const daemon::BoardFile file = reference_with(
      "[ceilings]\ncurrent_mA = 300\npower_W = 1.5\ntemperature_degC = 100\nstress_MPa = 200\n"
      "trip_current_mA = 350\ntrip_temperature_degC = 115\ntrip_stress_MPa = 250\n");
  EXPECT_EQ(file.ceilings.current_A, 0.3F);
  EXPECT_EQ(file.ceilings.power_W, 1.5F);
  EXPECT_EQ(file.ceilings.temperature_K, 373.15F);
  EXPECT_EQ(file.ceilings.stress_Pa, 200e6F);
  EXPECT_EQ(file.ceilings.trip_current_A, 0.35F);
  EXPECT_EQ(file.ceilings.trip_temperature_K, 388.15F);
  EXPECT_EQ(file.ceilings.trip_stress_Pa, 250e6F);
  EXPECT_EQ(reference_with("[ceilings]\ncurrent_mA = 800\n").ceilings.current_A, 0.5F)
      << "nothing raises the hardware's";
}

TEST(BoardFile, EachCeilingHoldsForSettingsFromAnywhere) {
  const char* const names[] = {"current_mA",     "power_W",         "temperature_degC",
                               "stress_MPa",     "trip_current_mA", "trip_temperature_degC",
                               "trip_stress_MPa"};
  const Settings<double> settings =
      text::load_settings_file(boards() + "/devices/current-sink.toml");
  for (const char* const name : names) {
    const daemon::BoardFile file = reference_with(std::string("[ceilings]\n") + name + " = 1\n");
    EXPECT_NE(daemon::board_problem(file, settings).find("above the board's ceiling"),
              std::string::npos)
        << name;
  }
}

TEST(BoardFile, KeysOfTheAccessLevels) {
  const daemon::BoardFile file =
      reference_with("[bus]\ninterface = \"udp\"\ntune_key = 4294967295\nset_up_key = 77\n");
  ASSERT_TRUE(file.bus);
  EXPECT_EQ(file.bus->keys.tune, 4294967295U);
  EXPECT_EQ(file.bus->keys.set_up, 77U);
}

TEST(BoardFile, ThePeriodIs100HzTo2kHz) {
  Settings<double> settings = text::load_settings_file(boards() + "/devices/current-sink.toml");
  for (const double period_s : {0.0005, 0.001, 0.01}) {
    settings.timing.period_s = period_s;
    EXPECT_EQ(daemon::period_problem(stored_settings<double>(settings)), "") << period_s;
  }
  for (const double period_s : {0.000499, 0.0101}) {
    settings.timing.period_s = period_s;
    EXPECT_NE(daemon::period_problem(stored_settings<double>(settings)), "") << period_s;
  }
}

}  // namespace
}  // namespace smaservo::test::board_file_test
