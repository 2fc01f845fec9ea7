// What people feed in by mistake, and what the program then says: what it claims to have done is
// what it has done, and a result that nobody can use has an exit status of its own.

#include <cmath>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/host-sim/program.hpp"
#include "tests/host-sim/recordings.hpp"

namespace smaservo::test::mistakes_test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

/// Rows of a logger: a wire of 25 ohm whose current goes up and down.
class Logged {
 public:
  explicit Logged(double voltage_sign = 1) {
    for (int i = 0; i < 300; ++i) {
      const double current_A = 0.05 + 0.03 * std::sin(0.05 * i);
      rows_.push_back(fmt::format("{:.2f},{:.6f},{:.6f},0.68", 0.1 * i, current_A,
                                  voltage_sign * 25 * current_A));
    }
  }

  /// Another time in the row of this number.
  Logged& at(std::size_t row, const std::string& time) {
    rows_.at(row) = time + rows_.at(row).substr(rows_.at(row).find(','));
    return *this;
  }
  Logged& replace(std::size_t row, const std::string& text) {
    rows_.at(row) = text;
    return *this;
  }
  /// Another header and the times of the first rows again, from this row on.
  Logged& restarted(std::size_t row) {
    for (std::size_t i = row; i < rows_.size(); ++i) {
      at(i, fmt::format("{:.2f}", 0.1 * static_cast<double>(i - row)));
    }
    rows_.insert(rows_.begin() + static_cast<std::ptrdiff_t>(row), header);
    return *this;
  }
  std::string text() const {
    std::string all = std::string(header) + "\n";
    for (const std::string& row : rows_) {
      all += row + "\n";
    }
    return all;
  }

 private:
  static constexpr const char* header = "time_s,current_A,voltage_V,load_N";
  std::vector<std::string> rows_;
};

Finished run_on(Program& program, const std::string& text, Program::Texts arguments) {
  program.folder().write("run.csv", text);
  return program.run(arguments);
}

Finished replayed(const std::string& text, const Program::Texts& more = {}) {
  Program program;
  Program::Texts arguments{"replay", "--json", "run.csv"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return run_on(program, text, arguments);
}

TEST(Mistakes, OneCorruptTimeCostsOneRow) {
  const std::string text = Logged().at(45, "3000000.00").text();
  EXPECT_EQ(replayed(text).status, 1);
  const Finished f = replayed(text, {"--lenient"});
  ASSERT_EQ(f.status, 0) << f.err;
  const auto json = nlohmann::json::parse(f.out);
  EXPECT_EQ(json["rows"], 299);
  EXPECT_EQ(json["skipped_rows"], 1);
  EXPECT_NEAR(json["duration_s"].get<double>(), 29.9, 1e-9);
  EXPECT_THAT(json["complaints"][0].get<std::string>(), HasSubstr("line 47, column 1 (time_s): "));
}

TEST(Mistakes, ALoggerThatBeganAnewIsTwoPieces) {
  const Finished f = replayed(Logged().restarted(150).text(), {"--lenient"});
  ASSERT_EQ(f.status, 0) << f.err;
  const auto json = nlohmann::json::parse(f.out);
  EXPECT_EQ(json["rows"], 300);
  EXPECT_EQ(json["skipped_rows"], 0);
  EXPECT_THAT(f.err, HasSubstr("1 header among the rows was skipped"));
  EXPECT_EQ(json["restarts"], 1) << "what happened in between is not known";
  EXPECT_THAT(json["clock"][0].get<std::string>(), HasSubstr("a new piece"));
}

TEST(Mistakes, AShuntTheWrongWayRoundIsSaid) {
  const std::string text = Logged(-1).text();
  const Finished f = replayed(text);
  EXPECT_EQ(f.status, 1);
  EXPECT_EQ(f.out, "");
  EXPECT_THAT(f.err,
              HasSubstr("voltage and current have opposite signs (a resistance of -25 ohm)"));
  EXPECT_THAT(f.err, HasSubstr("--column current_A=2*-1"));
  EXPECT_EQ(replayed(text, {"--column", "current_A=current_A*-1"}).status, 0);
}

TEST(Mistakes, ARunWithoutAnyResistanceIsRefused) {
  const Finished f = replayed(Logged(0.2).text(), {"--allow", "resistivity"});
  EXPECT_EQ(f.status, 1);
  EXPECT_THAT(f.err, HasSubstr("run.csv: no row has a valid resistance"));
  EXPECT_EQ(nlohmann::json::parse(f.out)["invalid_rows"], 300) << "the numbers are printed";
}

/// The numbers of an MCAP file's log_time, its schema, and one message, by the reader of others'.
Finished converted(Program& program, const std::string& text) {
  return run_on(program, text, {"convert", "run.csv", "--out", "run.mcap"});
}

TEST(Mistakes, AHeaderInTheMiddleMakesNoTexts) {
  Program program;
  const Finished f = converted(program, Logged().restarted(150).text());
  ASSERT_EQ(f.status, 0) << f.err;
  EXPECT_THAT(f.out, HasSubstr("line 152: the header stands here again: left out"));
  EXPECT_THAT(f.out, HasSubstr("line 153, column 1 (time_s): time 0.00 comes after a later one"));
  const Finished back = program.run({"convert", "run.mcap", "--out", "-"});
  EXPECT_THAT(back.err, HasSubstr("300 rows, 4 columns"));
  const Finished plain = program.run({"convert", "run.csv", "--out", "u.mcap", "--uncompressed"});
  EXPECT_EQ(plain.status, 0);
  EXPECT_THAT(file_text(program.folder() / "u.mcap"), Not(HasSubstr(R"("type":"string")")));
}

TEST(Mistakes, ADateIsNoTimeInSeconds) {
  Logged logged;
  for (std::size_t i = 0; i < 300; ++i) {
    logged.at(i, fmt::format("2026-11-27T10:{:02}:{:02}.000", i / 60, i % 60));
  }
  Program program;
  const Finished f = converted(program, logged.text());
  EXPECT_EQ(f.status, 1);
  EXPECT_THAT(f.err, HasSubstr("run.csv: line 2: column 1 (time_s): '2026-11-27T10:00:00.000' is "
                               "no number, of which log_time is made"));
  std::string other = logged.text();
  other.replace(0, 6, "Date");
  EXPECT_THAT(converted(program, other).err, HasSubstr("run.csv: line 1: Date: is no column of "
                                                       "time that is understood"));
  EXPECT_EQ(program.folder().names().size(), 1U) << "no file is left";
}

TEST(Mistakes, AnotherProgramsTableIsConvertedToOurDialect) {
  std::string text = Logged().text();
  std::ranges::replace(text, ',', ';');
  text.replace(0, text.find('\n'), "t [ms];I [A];U [V];Kraft [N]");
  Program program;
  const Finished f = run_on(program, text, {"convert", "run.csv", "--out", "own.csv"});
  ASSERT_EQ(f.status, 0) << f.err;
  EXPECT_THAT(file_text(program.folder() / "own.csv"),
              HasSubstr("time_ms,current_A,voltage_V,load_N\n0.00,0.050000,1.250000,0.68\n"));
  EXPECT_THAT(f.err, HasSubstr("time = column 1 't [ms]' in ms"));
  const Finished mcap = run_on(program, text, {"convert", "run.csv", "--out", "own.mcap"});
  ASSERT_EQ(mcap.status, 0) << mcap.err;
  EXPECT_EQ(program.run({"convert", "own.mcap", "--out", "-"}).out,
            file_text(program.folder() / "own.csv"));
}

TEST(Mistakes, AFewWordsAmongNumbersAreLeftOutAndSaid) {
  Program program;
  const std::string text = Logged()
                               .replace(20, "2.00,ERR,1.25,0.68")
                               .replace(21, "2.10,nan,1.25,0.68")
                               .replace(22, "2.20,ERR,1.25,0.68")
                               .text();
  const Finished f = converted(program, text);
  ASSERT_EQ(f.status, 0) << f.err;
  EXPECT_THAT(f.out, HasSubstr("line 22, column 2 (current_A): 'ERR' in a column of numbers: left "
                               "out, and 2 more"));
  const Finished back = program.run({"convert", "run.mcap", "--out", "-"});
  EXPECT_THAT(back.out, HasSubstr("\n2.00,,1.25,0.68\n"));
}

TEST(Mistakes, WhatIsNoTableOfNumbersIsNotConverted) {
  Program program;
  const Finished f = converted(program, "time_s;current_A;note\non;off;x\non;off;y\n");
  EXPECT_EQ(f.status, 1);
  EXPECT_THAT(f.err, HasSubstr("one column, 'time_s;current_A;note'; columns must be "
                               "separated by commas, not by ';'"));
  EXPECT_THAT(converted(program, "note\nready\nnot ready\n").err,
              HasSubstr("no column has numbers"));
  EXPECT_EQ(program.folder().names().size(), 1U);
}

Finished identified(const std::string& text) {
  Program program;
  program.folder().write("run.csv", text);
  Finished f = program.run({"identify", "--out", "w.toml", "run.csv"});
  EXPECT_EQ(program.folder().names().size(), f.status == 0 ? 2U : 1U);
  return f;
}

TEST(Mistakes, ExothermicUpwardsIsSaid) {
  std::vector<double> time_s, temperature, flow;
  for (int i = 0; i < 400; ++i) {
    const double T = i < 200 ? 10 + 0.5 * i : 210 - 0.5 * i;
    const double peak = std::exp(-std::pow((T - (i < 200 ? 75 : 50)) / 4, 2));
    time_s.push_back(3.0 * i);
    temperature.push_back(T);
    flow.push_back((i < 200 ? -1 : 1) * (0.08 + 0.3 * peak));
  }
  const Finished f = identified(
      csv({{"time_s", time_s}, {"temperature_degC", temperature}, {"power_W_per_g", flow}}));
  EXPECT_EQ(f.status, 1);
  EXPECT_THAT(f.err, AllOf(HasSubstr("run.csv: the heat flow runs against the temperature"),
                           HasSubstr("--column power_W_per_g=3*-1")));
}

TEST(Mistakes, QuantitiesWithTheWrongSignAreRefusedBeforeAFit) {
  const Recording r;
  const RecordedColumn stress{"stress_MPa", std::vector<double>(r.strain.size(), 150.0)};
  const RecordedColumn temperature{"temperature_degC", r.temperature_degC};
  EXPECT_THAT(identified(csv({temperature, {"strain_ref", times(-1, r.strain)}, stress})).err,
              HasSubstr("the wire gets longer where it is heated"));
  EXPECT_THAT(identified(csv({temperature,
                              {"strain_ref", r.strain},
                              {"load_N", std::vector<double>(r.strain.size(), -0.7)}}))
                  .err,
              HasSubstr("a pull is positive"));
  EXPECT_THAT(identified(csv({{"time_s", r.time_s},
                              {"current_A", times(-1, r.current_A)},
                              {"voltage_V", r.voltage_V},
                              {"strain_ref", r.strain},
                              stress}))
                  .err,
              HasSubstr("voltage and current have opposite signs"));
}

}  // namespace
}  // namespace smaservo::test::mistakes_test
