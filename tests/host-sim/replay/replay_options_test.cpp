// What a replay does with options, references, gaps and mistakes.

#include <algorithm>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/host-sim/replay/replays.hpp"

namespace smaservo::test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

/// Header and the first 15 s of a trace at 100 Hz with two full cycles begun.
std::vector<std::string> short_trace() {
  return first_lines("200MPa.csv", 1500);
}

struct Columns {
  std::string time, current, voltage, load, strain_ref;
};
Columns split(const std::string& line) {
  Columns c;
  std::istringstream in(line);
  for (std::string* field : {&c.time, &c.current, &c.voltage, &c.load, &c.strain_ref}) {
    std::getline(in, *field, ',');
  }
  return c;
}

/// Every row of the short trace made into another text.
std::string rewritten(const std::string& header, const auto& row_text) {
  std::vector<std::string> lines = short_trace();
  lines.front() = header;
  for (std::size_t i = 1; i < lines.size(); ++i) {
    lines[i] = row_text(split(lines[i]));
  }
  return joined(lines);
}

class ReplayOf : public ::testing::Test {
 protected:
  replay::ReplayOptions options(const std::string& text) const {
    return replay_options(folder_.write("trace.csv", text), "b");
  }
  Estimated of(const std::string& text) const { return estimated(options(text)); }

  /// What is said about a replay that is refused; nothing may be written then.
  static std::string refusal(replay::ReplayOptions options) {
    const TemporaryFolder out;
    options.out = out / "estimate.csv";
    std::string said;
    try {
      replay::replay(options);
    } catch (const std::runtime_error& error) {
      said = error.what();
    }
    if (!said.empty()) {
      EXPECT_THAT(out.names(), IsEmpty()) << said;
    }
    return said;
  }

  TemporaryFolder folder_;
};

TEST_F(ReplayOf, TheSameTraceIsTheSameWhateverRanBefore) {
  replay::ReplayOptions first = options(joined(short_trace()));
  first.observers = {"kalman", "open-loop", "line"};
  const Estimated before = estimated(first);
  estimated(replay_options(shipped("spring.csv"), "a"));
  const Estimated after = estimated(first);
  EXPECT_TRUE(before.text == after.text);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(before.result.observers[i].error.mean(), after.result.observers[i].error.mean());
    EXPECT_EQ(before.result.observers[i].error.maximum(),
              after.result.observers[i].error.maximum());
  }
}

// As a spreadsheet of another country writes it.
TEST_F(ReplayOf, ATableOfAnotherProgramHasTheSameEstimate) {
  std::string table = "Messung 7;;;;\n\n";
  table += rewritten("Zeit [ms];Strom in mA;Spannung/V;Kraft (N);strain_ref", [](const Columns& c) {
    std::string row = fmt::format("{};{};{};{};{}", 1e3 * std::stod(c.time),
                                  1e3 * std::stod(c.current), c.voltage, c.load, c.strain_ref);
    std::ranges::replace(row, '.', ',');
    return row;
  });
  table.pop_back();
  const Estimated expected = of(joined(short_trace()));
  const Estimated e = of(table);
  EXPECT_EQ(e.result.rows, expected.result.rows);
  EXPECT_TRUE(e.result.has_reference);
  for (std::size_t i = 0; i < e.result.rows; ++i) {
    ASSERT_NEAR(e.column("strain")[i], expected.column("strain")[i], 1e-6);
  }
}

TEST_F(ReplayOf, FirstObserverWritesTheOthersAreCompared) {
  replay::ReplayOptions both = options(joined(short_trace()));
  both.observers = {"line", "kalman"};
  const Estimated e = estimated(both);
  ASSERT_THAT(e.result.observers, SizeIs(2));
  replay::ReplayOptions alone = both;
  for (std::size_t i = 0; i < 2; ++i) {
    alone.observers = {both.observers[i]};
    const Estimated single = estimated(alone);
    EXPECT_EQ(e.result.observers[i].name, both.observers[i]);
    EXPECT_EQ(e.result.observers[i].error.mean(), single.result.observers[0].error.mean());
    EXPECT_EQ(e.text == single.text, i == 0);
  }
}

TEST_F(ReplayOf, WithoutReferenceOnlyTheFirstObserverRuns) {
  replay::ReplayOptions o =
      options(rewritten("time_s,current_A,voltage_V,load_N", [](const Columns& c) {
        return c.time + "," + c.current + "," + c.voltage + "," + c.load;
      }));
  o.observers = {"kalman", "line"};
  const Estimated e = estimated(o);
  EXPECT_FALSE(e.result.has_reference);
  ASSERT_THAT(e.result.observers, SizeIs(1));
  EXPECT_EQ(e.result.observers[0].error.count(), 0U);
  EXPECT_EQ(e.column("strain"), of(joined(short_trace())).column("strain"));
}

TEST_F(ReplayOf, ABadRowIsRefusedOrSkipped) {
  std::vector<std::string> lines = short_trace();
  const std::string good = joined(lines);
  lines.insert(lines.begin() + 701, "7.0000001,0.1,broken,0.9,0.04");
  replay::ReplayOptions o = options(joined(lines));
  EXPECT_THAT(refusal(o), HasSubstr("line 702, column 3 (voltage_V): 'broken'"));
  o.trace_options.lenient = true;
  const Estimated e = estimated(o);
  EXPECT_EQ(e.result.skipped, 1U);
  EXPECT_THAT(e.result.complaints, SizeIs(1));
  EXPECT_TRUE(e.text == of(good).text) << "as if the row had never been there";
}

TEST_F(ReplayOf, AGapOfMoreThanAMinuteStartsAgain) {
  const auto with_gap = [](double gap_s) {
    std::vector<std::string> lines = short_trace();
    for (std::size_t i = 1000; i < lines.size(); ++i) {
      const std::string rest = lines[i].substr(lines[i].find(','));
      lines[i] = std::to_string(static_cast<double>(i - 1) * 0.01 + gap_s) + rest;
    }
    return joined(lines);
  };
  EXPECT_EQ(of(with_gap(59)).result.restarts, 0U);
  const Estimated e = of(with_gap(61));
  EXPECT_EQ(e.result.restarts, 1U);
  EXPECT_EQ(e.result.rows, 1500U);
  std::vector<std::string> second = lines_of(with_gap(61));
  second.erase(second.begin() + 1, second.begin() + 1000);
  const std::vector<double> alone = of(joined(second)).column("strain");
  const std::vector<double>& all = e.column("strain");
  EXPECT_TRUE(std::equal(alone.begin(), alone.end(), all.end() - std::ssize(alone)));
}

TEST_F(ReplayOf, PeriodStandsInForTime) {
  replay::ReplayOptions o =
      options(rewritten("current_A,voltage_V,load_N,strain_ref", [](const Columns& c) {
        return c.current + "," + c.voltage + "," + c.load + "," + c.strain_ref;
      }));
  EXPECT_THAT(refusal(o), HasSubstr("--period-s"));
  o.trace_options.period_s = 0.01;
  const Estimated e = estimated(o);
  EXPECT_TRUE(e.result.timed);
  EXPECT_EQ(e.text, of(joined(short_trace())).text);
}

TEST_F(ReplayOf, LoadMayBeGivenInsteadOfMeasured) {
  const std::string without =
      rewritten("time_s,current_A,voltage_V,strain_ref", [](const Columns& c) {
        return c.time + "," + c.current + "," + c.voltage + "," + c.strain_ref;
      });
  replay::ReplayOptions o = options(without);
  EXPECT_THAT(refusal(o), AllOf(HasSubstr("--load-N"), HasSubstr("--stress-MPa")));
  o.stress_Pa = 200e6;
  const Estimated by_stress = estimated(o);
  EXPECT_LT(by_stress.result.observers[0].error.mean(), 1);
  o.stress_Pa.reset();
  o.load_N = 200e6 * o.wire.wire.geometry.area_m2();
  const Estimated by_load = estimated(o);
  EXPECT_LE(max_difference(by_stress.column("strain"), by_load.column("strain")), 1e-6);
  const Estimated column =
      of(rewritten("time_s,current_A,voltage_V,stress_MPa,strain_ref", [](const Columns& c) {
        return c.time + "," + c.current + "," + c.voltage + ",200," + c.strain_ref;
      }));
  EXPECT_LE(max_difference(by_stress.column("strain"), column.column("strain")), 1e-6);
}

TEST_F(ReplayOf, AnExplicitLoadDoesNotReplaceAMeasuredOne) {
  replay::ReplayOptions o = options(joined(short_trace()));
  const std::string measured = estimated(o).text;
  o.load_N = 2;
  EXPECT_TRUE(estimated(o).text == measured);
}

TEST_F(ReplayOf, DisplacementIsAReferenceWithoutZero) {
  const double length_m = files::load_wire(shipped("units/b.toml")).wire.geometry.length_m;
  const Estimated e =
      of(rewritten("time_s,current_A,voltage_V,load_N,displacement_mm", [&](const Columns& c) {
        const double mm = 7 - 1e3 * length_m * std::strtod(c.strain_ref.c_str(), nullptr);
        return c.time + "," + c.current + "," + c.voltage + "," + c.load + "," + std::to_string(mm);
      }));
  const Estimated known = of(joined(short_trace()));
  EXPECT_EQ(e.column("strain"), known.column("strain"));
  const std::vector<double>& got = e.column("strain_ref");
  const std::vector<double>& real = known.column("strain_ref");
  const double first = e.column("strain").front();
  EXPECT_NEAR(got.front(), first, 1e-6);
  for (std::size_t i = 0; i < got.size(); ++i) {
    ASSERT_NEAR(got[i] - first, real[i] - real.front(), 1e-6);
  }
}

TEST_F(ReplayOf, MissingColumnsAreNamed) {
  const std::string said = refusal(options("time_s,current_A,speed\n0,1,2\n"));
  for (const char* part : {"trace.csv", "voltage_V", "temperature_degC", "--column",
                           "has: time_s, current_A, speed"}) {
    EXPECT_THAT(said, HasSubstr(part));
  }
}

TEST_F(ReplayOf, ATraceWithoutRowsIsRefused) {
  EXPECT_THAT(refusal(options("time_s,current_A,voltage_V,load_N\n")), HasSubstr("no usable row"));
  replay::ReplayOptions o = options("time_s,current_A,voltage_V,load_N\nx,y,z,w\n");
  o.trace_options.lenient = true;
  EXPECT_THAT(refusal(o), HasSubstr("1 of 1 rows are bad"));
}

TEST_F(ReplayOf, MistakesInSettingsAreNamed) {
  const auto with = [&](const char* key, const char* value) {
    replay::ReplayOptions o = options(joined(short_trace()));
    o.settings = {{key, value}};
    return refusal(o);
  };
  EXPECT_THAT(with("observer.nonsense", "1"),
              AllOf(HasSubstr("observer.nonsense = 1: unknown key; [observer] has: "),
                    HasSubstr("ambient_walk_K")));
  EXPECT_THAT(with("kalman.loss_range", "2"),
              HasSubstr("--set: kalman.loss_range = 2: is now called observer.loss_range"));
  EXPECT_THAT(with("measurement.nonsense", "1"), HasSubstr("lead_resistance_ohm"));
  EXPECT_THAT(with("observer.ambient_walk_K", "-1"),
              HasSubstr("observer.ambient_walk_K = -1: must"));
  EXPECT_THAT(with("observer.ambient_walk_K", "nan"), HasSubstr("= nan: must be"));
  EXPECT_THAT(with("observer.loss_range", "0.5"), HasSubstr("must be between 1 and 1e+09, is 0.5"));
  EXPECT_THAT(with("measurement.lead_resistance_ohm", "1x"),
              HasSubstr("= '1x': must be a finite number"));
  replay::ReplayOptions o = options(joined(short_trace()));
  o.observers = {"clairvoyant"};
  EXPECT_THAT(refusal(o), AllOf(HasSubstr("clairvoyant"), HasSubstr("kalman, open-loop, line")));
}

TEST_F(ReplayOf, ABathDoesNotSwallowMistakes) {
  replay::ReplayOptions o = replay_options(shipped("bath.csv"), "b");
  o.settings = {{"observer.nonsense", "1"}};
  EXPECT_THAT(refusal(o), HasSubstr("observer.nonsense"));
}

TEST_F(ReplayOf, LeadResistanceIsTakenOff) {
  const std::string longer =
      rewritten("time_s,current_A,voltage_V,load_N,strain_ref", [](const Columns& c) {
        const double volt = std::strtod(c.voltage.c_str(), nullptr);
        const double ampere = std::strtod(c.current.c_str(), nullptr);
        return c.time + "," + c.current + "," + std::to_string(volt + 1.5 * ampere) + "," + c.load +
               "," + c.strain_ref;
      });
  replay::ReplayOptions o = options(longer);
  const double spoilt = estimated(o).result.observers[0].error.mean();
  o.settings = {{"measurement.lead_resistance_ohm", "1.5"}};
  const double mended = estimated(o).result.observers[0].error.mean();
  const double original = of(joined(short_trace())).result.observers[0].error.mean();
  EXPECT_NEAR(mended, original, 0.02);
  EXPECT_GT(spoilt, 2 * mended);
}

TEST_F(ReplayOf, RowsNearerThanANanosecondDoNoHarm) {
  std::vector<std::string> lines = short_trace();
  for (std::size_t i = 400; i < lines.size(); i += 200) {
    Columns c = split(lines[i]);
    c.time += "0000000001";
    lines.insert(lines.begin() + static_cast<std::ptrdiff_t>(i) + 1,
                 c.time + "," + c.current + "," + c.voltage + "," + c.load + "," + c.strain_ref);
  }
  const Estimated e = of(joined(lines));
  for (const double strain : e.column("strain")) {
    ASSERT_TRUE(std::isfinite(strain));
  }
  EXPECT_LT(e.result.observers[0].error.mean(), 1);
}

TEST_F(ReplayOf, ABathNeedsNoTimeAndStandingStillChangesNothing) {
  const std::vector<std::string> lines = first_lines("bath.csv", 3000);
  std::vector<std::string> twice{lines.front()};
  for (std::size_t i = 1; i < lines.size(); ++i) {
    twice.insert(twice.end(), 2, lines[i]);
  }
  const Estimated once = of(joined(lines));
  const Estimated doubled = of(joined(twice));
  EXPECT_TRUE(once.result.open_loop);
  EXPECT_FALSE(once.result.timed);
  ASSERT_EQ(doubled.table.rows(), 2 * once.table.rows());
  for (std::size_t i = 0; i < once.table.rows(); ++i) {
    for (const char* name : {"strain", "martensite", "r_phase", "resistance_model_ohm"}) {
      ASSERT_EQ(once.column(name)[i], doubled.column(name)[2 * i + 1]) << name;
    }
  }
}

}  // namespace
}  // namespace smaservo::test
