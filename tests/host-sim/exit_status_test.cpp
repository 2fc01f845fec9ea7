// The exit status of each command for each kind of input that is none: one table. What fails says
// so on standard error, in lines that name the file, and leaves nothing behind.

#include <cmath>
#include <fmt/format.h>
#include <functional>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <random>

#include "tests/host-sim/program.hpp"

namespace smaservo::test::exit_status_test {
namespace {

using ::testing::HasSubstr;

constexpr const char* header = "time_s,current_A,voltage_V,load_N,strain_ref";

std::string rows(const std::function<std::string(double time_s)>& row) {
  std::string text = std::string(header) + "\n";
  for (int i = 0; i < 300; ++i) {
    text += row(0.1 * i) + "\n";
  }
  return text;
}

/// A run of a wire that hardly moves: 25 ohm, read by scales of `current` and `voltage`.
std::string readings(double current, double voltage) {
  return rows([=](double t) {
    const double current_A = 0.05 + 0.03 * std::sin(0.5 * t);
    return fmt::format("{:.2f},{:.6f},{:.6f},0.68,0.03", t, current * current_A,
                       voltage * 25 * current_A);
  });
}

std::string noise() {
  std::mt19937_64 random(3);
  std::string text;
  for (int i = 0; i < 3000; ++i) {
    text += static_cast<char>(random() % 256);
  }
  return text;
}

/// What a user gives in place of a file of numbers.
struct Input {
  const char* what;
  std::string text;
  bool missing = false, folder = false;
};

const std::vector<Input>& inputs() {
  static const std::vector<Input> all{
      {"no file", "", true},
      {"a folder", "", false, true},
      {"an empty file", ""},
      {"a header alone", std::string(header) + "\n"},
      {"noise", noise()},
      {"nan", rows([](double t) { return fmt::format("{:.2f},nan,nan,nan,nan", t); })},
      {"words", rows([](double t) { return fmt::format("{:.2f},on,off,low,high", t); })},
      {"columns of nothing", "time_s,load_N\n0,1\n1,1\n2,1\n"},
      {"mA and mV for A and V", readings(1000, 1000)},
      {"a resistance of no wire", readings(1, 0.2)},
  };
  return all;
}

std::string device_settings() {
  return source_folder() + "/host-sim/scenarios/devices/sublayers-1000.toml";
}

struct Command {
  Program::Texts words;
  /// By input, in the order of inputs(): 0 done, 1 a mistake in the file, 3 done and of no use.
  std::vector<int> status;
};

const std::vector<Command>& commands() {
  static const std::vector<Command> all{
      //                                                     no  fo  em  he  no  na  wo  co  mA  ohm
      {{"replay", "in.csv"}, {1, 1, 1, 1, 1, 1, 1, 1, 1, 1}},
      {{"replay", "--lenient", "in.csv"}, {1, 1, 1, 1, 1, 1, 1, 1, 1, 1}},
      {{"replay-device", device_settings(), "in.csv"}, {1, 1, 1, 1, 1, 1, 1, 1, 1, 1}},
      {{"replay-device", "in.toml", "b.csv"}, {1, 1, 1, 1, 1, 1, 1, 1, 1, 1}},
      {{"identify", "--out", "w.toml", "in.csv"}, {1, 1, 1, 1, 1, 1, 1, 1, 1, 1}},
      {{"compare", "--train", "in.csv", "--test", "b.csv"}, {1, 1, 1, 1, 1, 1, 1, 1, 1, 1}},
      {{"convert", "in.csv", "--out", "o.mcap"}, {1, 1, 1, 1, 1, 0, 0, 0, 0, 0}},
      {{"simulate", "in.csv"}, {1, 1, 1, 1, 1, 1, 1, 1, 1, 1}},
      {{"calibrate-plan", "in.csv"}, {1, 1, 1, 1, 1, 1, 1, 1, 1, 1}},
      {{"replay", "b.csv", "--wire", "in.toml"}, {1, 1, 1, 1, 1, 1, 1, 1, 1, 1}},
      {{"describe", "settings", "--wire", "in.toml"}, {1, 1, 1, 1, 1, 1, 1, 1, 1, 1}},
      {{"tune", "--load-N", "0.5", "--wire", "in.toml"}, {1, 1, 1, 1, 1, 1, 1, 1, 1, 1}},
  };
  return all;
}

std::string line_of(const Program::Texts& words) {
  std::string text;
  for (const std::string& word : words) {
    text += " " + word;
  }
  return text;
}

TEST(ExitStatus, OfEveryCommandForEveryKindOfInput) {
  for (const Command& command : commands()) {
    for (std::size_t i = 0; i < inputs().size(); ++i) {
      const Input& input = inputs()[i];
      SCOPED_TRACE(std::string(input.what) + ":" + line_of(command.words));
      Program program;
      std::size_t files = 2;
      for (const char* name : {"in.csv", "in.toml"}) {
        if (input.folder) {
          std::filesystem::create_directory(program.folder() / name);
        } else if (!input.missing) {
          program.folder().write(name, input.text);
        } else {
          files = 0;
        }
      }
      program.folder().write("b.csv", readings(1, 1));
      const Finished f = program.run(command.words);
      const int expected = command.status.at(i);
      EXPECT_EQ(f.status, expected) << f.err;
      if (expected == 1) {
        EXPECT_EQ(f.out, "");
        EXPECT_THAT(f.err, HasSubstr("in."));
        EXPECT_EQ(program.folder().names().size(), files + 1) << "it has left something";
      }
      EXPECT_EQ(f.err.empty(), expected == 0);
    }
  }
}

}  // namespace
}  // namespace smaservo::test::exit_status_test
