// Exports of a PerkinElmer calorimeter, as its program Pyris writes them; the numbers are made up.

#include "hal/replay/sheet/pyris.hpp"

#include <cmath>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/hal/replay/traces.hpp"

namespace smaservo::test::pyris_test {
namespace {

using ::testing::HasSubstr;

constexpr double rate_K_min = 10;
constexpr double step_min = 1.0 / 60;
constexpr double zero_mW = -320, baseline_mW = 12;
constexpr double lag_rows = 20;  ///< until the sample follows the program

/// What an export consists of.
struct Export {
  std::string weight = "Sample Weight:\t50.000 mg ";
  std::string names =
      "\tTime     \tUnsubtracted\tBaseline     \tProgram     \tSample     \tApprox.      ";
  std::string below =
      "\t          \tHeat Flow \tHeat Flow \tTemperature\tTemperature\tGas Flow      ";
  bool baseline = true;
  char decimal = '.';
  std::string end = "\n";
  std::string tail = "\n\tDSC HEAT FLOW CALIBRATION INPUTS: \nWeight:\t   4.000 mg\tMethod:\tM \n";
};

/// Power into the sample, W/g, by how much it is transformed.
double power_W_g(double sample_degC, double direction) {
  return direction * (0.1 + 0.3 * std::exp(-std::pow((sample_degC - 40 - 10 * direction) / 4, 2)));
}

/// A hold, a cooling, a hold, a heating.
std::string text_of(const Export& e) {
  std::string text = "Filename:\tC:\\Data\\made up.dcd \nSample ID:\tmade up \n" + e.weight +
                     "\nDisplay Weight:\t50.000 \n1)\tHold for 1.0 min at 90.00\xB0" + "C \n";
  double now_min = 0;
  double sample_degC = 88;
  int step = 0;
  const auto row = [&](double flow_mW, double program_degC) {
    std::string line = fmt::format("\t{:.6f}\t{:.6f}", now_min, flow_mW);
    line += e.baseline ? fmt::format("\t{:.6f}", baseline_mW) : "";
    line += fmt::format("\t{:.6f}\t{:.6f}\t0.000000 \n", program_degC, sample_degC);
    text += line;
    now_min += step_min;
  };
  for (const double direction : {-1.0, 1.0}) {
    const double from_degC = direction < 0 ? 90 : 0;
    text += fmt::format("{}) DSC Isothermal \n", ++step);
    if (step == 1) {
      text += e.names + "\n" + e.below + "\n";
    }
    for (int i = 0; i < 60; ++i) {
      row(zero_mW + 99, from_degC);
    }
    text += fmt::format("{}) DSC Temperature Scan \n", ++step);
    for (int i = 0; i < 540; ++i) {
      const double lag = 1 - std::exp(-i * 3.5 / lag_rows);
      sample_degC += direction * rate_K_min * step_min * lag;
      const double own_mW = 50 * power_W_g(sample_degC, direction);
      row(zero_mW + (e.baseline ? baseline_mW : 0) + own_mW,
          from_degC + direction * rate_K_min * step_min * (i + 1));
    }
  }
  text += e.tail;
  if (e.decimal == ',') {
    std::ranges::replace(text, '.', ',');
  }
  for (std::size_t at = 0; e.end != "\n" && (at = text.find('\n', at)) != std::string::npos;
       at += e.end.size()) {
    text.replace(at, 1, e.end);
  }
  return text;
}

TraceContents read(const std::string& text) {
  hal::TraceOptions options;
  options.resistance_and_power = true;
  return read_trace(text, options);
}

/// The rows are those of the scans from where the sample follows, each with its own power.
void expect_scans(const TraceContents& contents) {
  ASSERT_GT(contents.rows.size(), 1020U);
  ASSERT_LT(contents.rows.size(), 1080U);
  EXPECT_EQ(contents.skipped, 0U);
  double before_s = 0;
  for (std::size_t i = 0; i < contents.rows.size(); ++i) {
    const double time_s = contents.at(i, hal::Column::time);
    const double direction = time_s < 660 ? -1 : 1;
    const double sample_K = contents.at(i, hal::Column::temperature);
    EXPECT_NEAR(contents.at(i, hal::Column::power) / 1e3,
                -320.0 / 50 + power_W_g(sample_K - 273.15, direction), 1e-6);
    EXPECT_GT(time_s, before_s);
    before_s = time_s;
  }
  EXPECT_NEAR(contents.at(0, hal::Column::time), 60, 25) << "minutes are read as such";
}

TEST(Pyris, ScansAreReadWithoutTheirHolds) {
  Export e;
  expect_scans(read(text_of(e)));
  e.end = "\r\n";
  expect_scans(read(text_of(e)));
  e = {};
  e.decimal = ',';
  expect_scans(read(text_of(e)));
  e = {};
  e.baseline = false;
  e.names = "\tTime     \tHeat Flow\tProgram     \tSample     \tApprox.      ";
  e.below = "\t          \t          \tTemperature\tTemperature\tGas Flow      ";
  expect_scans(read(text_of(e)));
}

/// A file that was cut off has fewer rows, and none with another number.
TEST(Pyris, ACutOffFileHasOnlyWholeRows) {
  Export e;
  e.tail = "";
  const std::string text = text_of(e);
  const TraceContents whole = read(text);
  for (std::size_t cut = 1; cut < 120; cut += 7) {
    const TraceContents part = read(text.substr(0, text.size() - cut));
    ASSERT_LT(part.rows.size(), whole.rows.size());
    EXPECT_TRUE(std::equal(part.rows.begin(), part.rows.end(), whole.rows.begin(),
                           [](const auto& a, const auto& b) {
                             return a[static_cast<std::size_t>(hal::Column::power)] ==
                                    b[static_cast<std::size_t>(hal::Column::power)];
                           }));
  }
}

TEST(Pyris, WhatIsMissingIsNamed) {
  Export e;
  e.weight = "Sample Weight:\t0.000 mg ";
  EXPECT_THAT(refusal(text_of(e)),
              HasSubstr("line 3: an export of Pyris whose sample weighs '0.000 "
                        "mg'"));
  e.weight = "Sample Weight:\tsix \x1b[31m mg ";
  EXPECT_THAT(refusal(text_of(e)), HasSubstr("'six \\x1B[31m mg'"));
  e.weight = "Sample Weight:\t50.000 oz ";
  EXPECT_THAT(refusal(text_of(e)), HasSubstr("'50.000 oz'"));
  e.weight = "Weight:\t50.000 mg ";
  EXPECT_THAT(refusal(text_of(e)), HasSubstr("without a line 'Sample Weight:'"));
  e = {};
  e.below = "\t          \tHeat Flow \tHeat Flow \tTemperature\tSetpoint\tGas Flow      ";
  EXPECT_THAT(refusal(text_of(e)), HasSubstr("without the column Sample Temperature"));
}

TEST(Pyris, OtherTablesAreNone) {
  const std::vector<std::string_view> table{"Filename: x", "time_s,current_A", "0,1"};
  EXPECT_FALSE(hal::PyrisExport::find(table));
  EXPECT_FALSE(hal::PyrisExport::find({}));
}

}  // namespace
}  // namespace smaservo::test::pyris_test
