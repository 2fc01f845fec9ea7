// What the estimates of the shipped traces are worth.

#include "host-sim/replay/replay.hpp"

#include <cstdlib>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <iostream>
#include <map>
#include <span>

#include "tests/host-sim/replay/replays.hpp"
#include "tests/places.hpp"

namespace smaservo::test {
namespace {

/// Error in % of the nominal stroke that a shipped trace is replayed with, by the wire's own
/// parameters. Bounds are 40 % to both sides: what becomes better deserves a new row, too.
struct Accuracy {
  const char* trace;
  const char* unit;
  double mean, p95;
};

void PrintTo(const Accuracy& accuracy, std::ostream* out) {
  *out << accuracy.trace;
}

constexpr Accuracy loaded[] = {
    {"100MPa", "b", 0.68, 1.15},    {"150MPa", "a", 0.08, 0.20},
    {"200MPa", "b", 0.08, 0.20},    {"400MPa", "a", 0.33, 0.51},
    {"spring", "a", 0.25, 0.45},    {"varying", "b", 0.14, 0.37},
    {"disturbed", "a", 0.16, 0.35}, {"unknown-start", "b", 2.31, 3.12},
};
constexpr Accuracy light[] = {
    {"10MPa", "a", 0.74, 1.54},
    {"25MPa", "b", 1.15, 2.23},
    {"50MPa", "a", 0.74, 1.39},
};
constexpr Accuracy bath[] = {{"bath", "b", 0.14, 1.05}};

/// Each trace is replayed once for all tests.
const Estimated& estimate_of(const Accuracy& a) {
  static std::map<std::string, Estimated> done;
  auto found = done.find(a.trace);
  if (found == done.end()) {
    const std::string trace = shipped(std::string(a.trace) + ".csv");
    found = done.emplace(a.trace, estimated(replay_options(trace, a.unit))).first;
  }
  return found->second;
}

const replay::ObserverResult& first_observer(const Accuracy& a) {
  return estimate_of(a).result.observers.front();
}

class ShippedTrace : public ::testing::TestWithParam<Accuracy> {};

TEST_P(ShippedTrace, ErrorIsWhatItWas) {
  const Accuracy& expected = GetParam();
  const replay::ErrorStatistics& reached = first_observer(expected).error;
  SCOPED_TRACE(fmt::format("reached is {{\"{}\", \"{}\", {:.2f}, {:.2f}}}", expected.trace,
                           expected.unit, reached.mean(), reached.quantile(0.95)));
  EXPECT_GT(reached.mean(), 0.6 * expected.mean);
  EXPECT_LT(reached.mean(), 1.4 * expected.mean);
  EXPECT_GT(reached.quantile(0.95), 0.6 * expected.p95);
  EXPECT_LT(reached.quantile(0.95), 1.4 * expected.p95);
  EXPECT_FALSE(first_observer(expected).lost);
}

TEST_P(ShippedTrace, EveryRowHasAnEstimateThatIsPhysical) {
  const Estimated& e = estimate_of(GetParam());
  ASSERT_EQ(e.table.rows(), e.result.rows);
  EXPECT_EQ(e.result.skipped, 0U);
  EXPECT_EQ(e.result.restarts, 0U);
  for (std::size_t i = 0; i < e.table.rows(); ++i) {
    const double martensite = e.column("martensite")[i];
    const double r_phase = e.column("r_phase")[i];
    const double austenite = e.column("austenite")[i];
    ASSERT_NEAR(martensite + r_phase + austenite, 1, 2e-5);
    ASSERT_GE(std::min({martensite, r_phase, austenite}), -1e-5);
    ASSERT_TRUE(e.column("strain")[i] > -0.01 && e.column("strain")[i] < 0.07) << "row " << i;
    ASSERT_TRUE(e.column("wire_temperature_degC")[i] > 0 &&
                e.column("wire_temperature_degC")[i] < 250);
  }
}

TEST_P(ShippedTrace, StatisticsAreThoseOfTheFile) {
  const Estimated& e = estimate_of(GetParam());
  double sum = 0;
  double maximum = 0;
  for (std::size_t i = 0; i < e.table.rows(); ++i) {
    const double percent = 100 * std::abs(e.column("strain")[i] - e.column("strain_ref")[i]) / 0.04;
    sum += percent;
    maximum = std::max(maximum, percent);
  }
  const replay::ErrorStatistics& error = first_observer(GetParam()).error;
  EXPECT_EQ(error.count(), e.table.rows());
  EXPECT_NEAR(error.mean(), sum / static_cast<double>(e.table.rows()), 3e-4);
  EXPECT_NEAR(error.maximum(), maximum, 3e-4);
}

const auto trace_name = [](const ::testing::TestParamInfo<Accuracy>& info) {
  std::string name = info.param.trace;
  std::erase(name, '-');
  return name;
};
INSTANTIATE_TEST_SUITE_P(Loaded, ShippedTrace, ::testing::ValuesIn(loaded), trace_name);
INSTANTIATE_TEST_SUITE_P(Light, ShippedTrace, ::testing::ValuesIn(light), trace_name);
INSTANTIATE_TEST_SUITE_P(Bath, ShippedTrace, ::testing::ValuesIn(bath), trace_name);

/// Errors of several traces, each with the same weight whatever its rate and length.
std::vector<double> pooled_errors(std::span<const Accuracy> traces) {
  constexpr std::size_t each = 4000;
  std::vector<double> errors;
  for (const Accuracy& trace : traces) {
    const Estimated& e = estimate_of(trace);
    for (std::size_t i = 0; i < each; ++i) {
      const std::size_t row = i * e.table.rows() / each;
      errors.push_back(100 * std::abs(e.column("strain")[row] - e.column("strain_ref")[row]) /
                       0.04);
    }
  }
  std::ranges::sort(errors);
  return errors;
}

double mean(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) {
    sum += value;
  }
  return sum / static_cast<double>(values.size());
}

TEST(ShippedTraces, MeetTheTargetsTogether) {
  const std::vector<double> heavy = pooled_errors(loaded);
  const double heavy_p95 = heavy[heavy.size() * 95 / 100];
  EXPECT_LE(mean(heavy), 1.0);
  EXPECT_LE(heavy_p95, 3.0);
  const std::vector<double> lighter = pooled_errors(light);
  EXPECT_LE(mean(lighter), 2.0);
  std::cout << "  100 MPa and more: mean " << mean(heavy) << " %, 95 % " << heavy_p95
            << " %; 10 to 50 MPa: mean " << mean(lighter) << " %\n";
}

TEST(ShippedTraces, TheStandardDeviationIsHonest) {
  for (const Accuracy& trace : loaded) {
    const Estimated& e = estimate_of(trace);
    std::size_t inside = 0;
    double errors = 0;
    double promised = 0;
    for (std::size_t i = 0; i < e.table.rows(); ++i) {
      const double sd = e.column("strain_sd")[i];
      const double off = std::abs(e.column("strain")[i] - e.column("strain_ref")[i]);
      inside += off <= 2 * sd ? 1U : 0U;
      errors += off * off;
      promised += sd * sd;
    }
    const double share = static_cast<double>(inside) / static_cast<double>(e.table.rows());
    EXPECT_GT(share, 0.9) << trace.trace << ": two of them hold most errors";
    EXPECT_LT(std::sqrt(promised / errors), 20) << trace.trace << ": nor are they an idle promise";
  }
}

constexpr std::size_t golden_every = 100;

TEST(Golden, EstimateOf150MPa) {
  const auto path = std::filesystem::path(test::source_folder()) / "tests/golden/replay_150MPa.csv";
  const std::vector<std::string> lines = lines_of(estimate_of(loaded[1]).text);
  std::vector<std::string> kept{lines.front()};
  for (std::size_t i = 1; i < lines.size(); i += golden_every) {
    kept.push_back(lines[i]);
  }
  if (std::getenv("SMASERVO_REWRITE_GOLDEN") != nullptr) {
    std::ofstream(path, std::ios::binary) << joined(kept);
    GTEST_SKIP() << path << " is written anew";
  }
  const NumberTable golden = parse_numbers(file_text(path));
  const NumberTable now = parse_numbers(joined(kept));
  ASSERT_EQ(golden.names, now.names);
  ASSERT_EQ(golden.rows(), now.rows());
  for (std::size_t i = 0; i < golden.columns.size(); ++i) {
    // Compilers differ in the last bits, and the filter does not amplify them.
    EXPECT_LE(max_difference(golden.columns[i], now.columns[i]), 1e-4 * range(golden.columns[i]))
        << golden.names[i] << " has changed. If that is wanted, run\n"
        << "  SMASERVO_REWRITE_GOLDEN=1 build/release/tests/host-sim/host_sim_tests "
           "--gtest_filter=Golden.*\nand commit the difference of "
        << path;
  }
}

}  // namespace
}  // namespace smaservo::test
