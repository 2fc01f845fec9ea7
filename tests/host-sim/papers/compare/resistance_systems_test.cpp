#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <limits>
#include <vector>

#include "host-sim/papers/compare/system.hpp"
#include "model/files/error.hpp"

namespace smaservo::test {
namespace {

using ::testing::HasSubstr;
constexpr double nothing = std::numeric_limits<double>::quiet_NaN();

/// From 20 ohm down to 17 and back, twice.
std::vector<double> there_and_back() {
  std::vector<double> ohm;
  constexpr int rows = 97;
  for (int leg = 0; leg < 4; ++leg) {
    for (int i = 0; i < rows; ++i) {
      const double way = 3.0 * i / rows;
      ohm.push_back(leg % 2 == 0 ? 20 - way : 17 + way);
    }
  }
  return ohm;
}

template <class Strain>
smaservo::identify::Run run_of(const std::vector<double>& ohm, Strain strain) {
  smaservo::identify::Run run{};
  run.name = "run.csv";
  run.kind = identify::RunKind::joule;
  run.resistance_ohm = ohm;
  for (std::size_t i = 0; i < ohm.size(); ++i) {
    run.strain.push_back(strain(i));
  }
  return run;
}

double falling(double ohm) {
  return 0.012 * (ohm - 16.5);
}
double rising(double ohm) {
  return 0.014 * (ohm - 17.1);
}

/// Up and down lines; the other one counts when the resistance has turned by 1 % of its first.
smaservo::identify::Run two_lined() {
  const std::vector<double> ohm = there_and_back();
  double turned = ohm.front();
  bool up = false;
  return run_of(ohm, [&](std::size_t i) {
    turned = up ? std::max(turned, ohm[i]) : std::min(turned, ohm[i]);
    if (std::abs(ohm[i] - turned) > 0.01 * ohm.front()) {
      up = !up;
      turned = ohm[i];
    }
    return up ? rising(ohm[i]) : falling(ohm[i]);
  });
}

void expect_same(const std::vector<double>& strain, const std::vector<double>& truth) {
  ASSERT_EQ(strain.size(), truth.size());
  for (std::size_t i = 0; i < strain.size(); ++i) {
    EXPECT_NEAR(strain[i], truth[i], 1e-10) << i;
  }
}

std::string refusal(compare::System (*identify)(const std::vector<smaservo::identify::Run>&),
                    const std::vector<smaservo::identify::Run>& runs) {
  try {
    identify(runs);
  } catch (const files::UserError& error) {
    return error.what();
  }
  return "";
}

TEST(ResistanceSystems, ALineIsFoundExactly) {
  const std::vector<double> ohm = there_and_back();
  const auto run = run_of(ohm, [&](std::size_t i) { return falling(ohm[i]); });
  const compare::System line = compare::one_line({run});
  EXPECT_EQ(line.parameters, 2);
  expect_same(line.strain(run), run.strain);
  expect_same(compare::polynomial({run}).strain(run), run.strain);
  expect_same(compare::two_lines({run}).strain(run), run.strain);
}

TEST(ResistanceSystems, APolynomialOfFourthOrderIsFoundExactly) {
  const std::vector<double> ohm = there_and_back();
  const auto run = run_of(ohm, [&](std::size_t i) {
    const double x = ohm[i] / 18 - 1;
    return 0.02 + 0.15 * x - 0.9 * x * x + 3 * x * x * x - 20 * x * x * x * x;
  });
  const compare::System fitted = compare::polynomial({run});
  EXPECT_EQ(fitted.parameters, 5);
  expect_same(fitted.strain(run), run.strain);
  EXPECT_GT(std::abs(compare::one_line({run}).strain(run)[0] - run.strain[0]), 1e-3);
}

TEST(ResistanceSystems, TwoLinesAreFoundExactlyOneForEachDirection) {
  const auto run = two_lined();
  const compare::System fitted = compare::two_lines({run});
  EXPECT_EQ(fitted.parameters, 4);
  expect_same(fitted.strain(run), run.strain);
}

TEST(ResistanceSystems, NoiseBelowOnePerCentDoesNotTurnTheDirection) {
  auto run = two_lined();
  const compare::System fitted = compare::two_lines({run});
  const std::vector<double> clean = fitted.strain(run);
  for (std::size_t i = 0; i < run.strain.size(); ++i) {
    run.resistance_ohm[i] += i % 2 == 0 ? 0.04 : -0.04;
  }
  const std::vector<double> noisy = fitted.strain(run);
  int jumps = 0;
  for (std::size_t i = 0; i < clean.size(); ++i) {
    // The lines are up to 0.011 apart; noise moves along them by 0.0006.
    jumps += std::abs(noisy[i] - clean[i]) > 0.001 ? 1 : 0;
  }
  EXPECT_LT(jumps, 12) << "but for a few rows at each turn";
}

TEST(ResistanceSystems, TheLastValueIsHeldWhereThereIsNoResistance) {
  auto run = two_lined();
  const compare::System systems[] = {compare::one_line({run}), compare::polynomial({run}),
                                     compare::two_lines({run})};
  for (const std::size_t i : {0U, 1U, 50U, 51U, 52U, 387U}) {
    run.resistance_ohm[i] = nothing;
  }
  for (const compare::System& system : systems) {
    const std::vector<double> strain = system.strain(run);
    EXPECT_TRUE(std::isnan(strain[0]) && std::isnan(strain[1])) << "nothing to hold yet";
    EXPECT_TRUE(std::isfinite(strain[2]));
    EXPECT_EQ(strain[52], strain[49]);
    EXPECT_NE(strain[53], strain[49]);
    EXPECT_EQ(strain[387], strain[386]);
  }
}

TEST(ResistanceSystems, RowsWithoutResistanceDoNotCountInTheFit) {
  auto run = two_lined();
  const compare::System systems[] = {compare::one_line({run}), compare::polynomial({run}),
                                     compare::two_lines({run})};
  auto gaps = run;
  for (std::size_t i = 0; i < run.strain.size(); i += 3) {
    // Behind each row one without resistance, of a wild strain
    const auto at = static_cast<std::ptrdiff_t>(gaps.strain.size() - i);
    gaps.strain.insert(gaps.strain.begin() + at, 0.9);
    gaps.resistance_ohm.insert(gaps.resistance_ohm.begin() + at, nothing);
  }
  const compare::System others[] = {compare::one_line({gaps}), compare::polynomial({gaps}),
                                    compare::two_lines({gaps})};
  for (int i = 0; i < 3; ++i) {
    expect_same(others[i].strain(run), systems[i].strain(run));
  }
}

TEST(ResistanceSystems, ARunWithoutResistanceIsSkippedAndGetsNoStrain) {
  const auto run = two_lined();
  auto bath = run;
  bath.kind = identify::RunKind::bath;
  bath.resistance_ohm.clear();
  for (const compare::System& system :
       {compare::one_line({bath, run}), compare::two_lines({bath, run})}) {
    const std::vector<double> strain = system.strain(bath);
    ASSERT_EQ(strain.size(), bath.strain.size());
    EXPECT_TRUE(std::ranges::all_of(strain, [](double x) { return std::isnan(x); }));
  }
  expect_same(compare::one_line({bath, run}).strain(run), compare::one_line({run}).strain(run));
}

TEST(ResistanceSystems, RunsCountAlikeHoweverManyRowsTheyHave) {
  const std::vector<double> ohm = there_and_back();
  std::vector<double> often;
  for (const double one : ohm) {
    often.insert(often.end(), 7, one);
  }
  const auto high = run_of(ohm, [&](std::size_t i) { return falling(ohm[i]) + 0.004; });
  const auto low = run_of(often, [&](std::size_t i) { return falling(often[i]) - 0.004; });
  const auto middle = run_of(ohm, [&](std::size_t i) { return falling(ohm[i]); });
  expect_same(compare::one_line({high, low}).strain(middle), middle.strain);
  expect_same(compare::polynomial({low, high}).strain(middle), middle.strain);
}

TEST(ResistanceSystems, WhatCannotBeIdentifiedIsRefused) {
  auto run = two_lined();
  for (const auto identify : {&compare::one_line, &compare::polynomial, &compare::two_lines}) {
    EXPECT_EQ(refusal(identify, {}), "no run has a resistance");
    auto none = run;
    none.resistance_ohm.clear();
    EXPECT_EQ(refusal(identify, {none}), "no run has a resistance");
    auto constant = run;
    constant.resistance_ohm.assign(run.strain.size(), 20.0);
    EXPECT_THAT(refusal(identify, {constant}), HasSubstr("over a whole motion"));
  }
  // Only falling: a line and a polynomial, but not two lines
  run.strain.resize(90);
  run.resistance_ohm.resize(90);
  EXPECT_EQ(refusal(&compare::one_line, {run}), "");
  EXPECT_EQ(refusal(&compare::polynomial, {run}), "");
  EXPECT_THAT(refusal(&compare::two_lines, {run}), HasSubstr("over a whole motion"));
}

}  // namespace
}  // namespace smaservo::test
