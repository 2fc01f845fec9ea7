#include "host-sim/papers/compare/compare.hpp"

#include <algorithm>
#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <limits>
#include <map>
#include <string_view>

#include "model/files/error.hpp"
#include "tests/host-sim/recordings.hpp"
#include "tests/host-sim/replay/replays.hpp"

namespace smaservo::test {
namespace {

using ::testing::AllOf;
using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::Ge;
using ::testing::HasSubstr;
using ::testing::IsSupersetOf;
using ::testing::Le;
using Runs = std::vector<smaservo::identify::Run>;

/// The type's preset, with the length that is measured on every wire.
files::WireDescription type_of_unit_a() {
  return files::load_wire("smartflex-76um", {{"wire.length_mm", "100.6"}});
}

/// A shipped trace of wire a up to some time, and of its rows every so many.
smaservo::identify::Run trace(const std::string& name, std::size_t every, double until_s = 1e9) {
  smaservo::identify::Run run =
      identify::read_run(shipped(name + ".csv"), {type_of_unit_a().wire.geometry, {}, {}, {}});
  std::size_t kept = 0;
  const std::vector<double> time_s = run.time_s;
  for (std::size_t i = 0; i < time_s.size() && time_s[i] < until_s; i += every) {
    for (auto* column : {&run.time_s, &run.current_A, &run.voltage_V, &run.stress_Pa, &run.strain,
                         &run.resistance_ohm}) {
      (*column)[kept] = (*column)[i];
    }
    ++kept;
  }
  for (auto* column : {&run.time_s, &run.current_A, &run.voltage_V, &run.stress_Pa, &run.strain,
                       &run.resistance_ohm}) {
    column->resize(kept);
  }
  return run;
}

/// As a laser measures it, with a zero of its own.
smaservo::identify::Run displaced(smaservo::identify::Run run) {
  const double longest = *std::ranges::max_element(run.strain);
  for (double& strain : run.strain) {
    strain -= longest;
  }
  return run;
}

const auto no_progress = [](std::string_view, double) {};

const compare::Compared& named(const compare::Comparison& comparison, std::string_view name) {
  const auto found = std::ranges::find_if(
      comparison.systems, [&](const compare::Compared& one) { return one.system.name == name; });
  if (found == comparison.systems.end()) {
    throw files::UserError("no such system");
  }
  return *found;
}

std::string refusal(const Runs& training, const Runs& tests) {
  try {
    compare::compare(files::load_wire("smartflex-76um"), training, tests, 1, no_progress);
  } catch (const files::UserError& error) {
    return error.what();
  }
  return "";
}

/// Mean of the differences to another strain, and how far they go from it.
struct Offset {
  double mean, max;
};
Offset offset(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0;
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  double rows = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (std::isfinite(a[i] - b[i])) {
      sum += a[i] - b[i];
      low = std::min(low, a[i] - b[i]);
      high = std::max(high, a[i] - b[i]);
      ++rows;
    }
  }
  return {sum / rows, high - low};
}

// One test, since identifying takes most of its time.
TEST(Compare, TheObserverIsFarAheadOnTheProjectsTraces) {
  const Runs training{trace("10MPa", 2, 22), trace("50MPa", 2, 22), trace("150MPa", 20),
                      trace("400MPa", 2, 22)};
  const smaservo::identify::Run spring = trace("spring", 3);
  std::vector<std::string> steps;
  std::vector<double> shares;
  const compare::Comparison all = compare::compare(
      type_of_unit_a(), training, {spring, trace("disturbed", 3), displaced(spring)}, 2,
      [&](std::string_view step, double share) {
        steps.emplace_back(step);
        shares.push_back(share);
      });

  // Means in % of the stroke, of a system against the spring and disturbed
  struct Expected {
    double spring, disturbed;
  };
  const std::map<std::string, Expected> expected{
      {"one line", {3.24, 5.63}},       {"polynomial", {3.24, 7.31}},
      {"two lines", {4.13, 7.63}},      {"stress-strain-resistance", {1.68, 3.97}},
      {"Duhem", {6.27, 7.49}},          {"Liang-Rogers", {10.6, 10.4}},
      {"Preisach", {1.08, 5.06}},       {"ihyp", {2.00, 5.99}},
      {"ihyp observer", {0.302, 0.201}}};
  const compare::Compared& observer = named(all, "ihyp observer");
  for (const auto& [name, error] : expected) {
    const compare::Compared& one = named(all, name);
    ASSERT_EQ(one.runs.size(), 3U) << one.system.remark;
    // Where the fit of ihyp ends depends on the last bits: of the C library's functions, which
    // differ by processor, and of its start. Two builds that differed in the rounding of a 0
    // gave 1.87 and 2.00. Preisach takes the heat balance of this fit: 0.90 and 1.08.
    const bool by_fit = std::string_view(name) == "ihyp" || std::string_view(name) == "Preisach";
    const double slack = by_fit ? 0.3 : 0.2;
    EXPECT_NEAR(one.runs[0].error.mean(), error.spring, slack * error.spring) << name;
    EXPECT_NEAR(one.runs[1].error.mean(), error.disturbed, 0.2 * error.disturbed) << name;
    EXPECT_EQ(one.error.count(),
              one.runs[0].error.count() + one.runs[1].error.count() + one.runs[2].error.count());
    EXPECT_GT(one.step_s, 0);
    EXPECT_GE(one.system.parameters, 2);
    if (&one != &observer) {
      EXPECT_GT(one.error.mean(), 5 * observer.error.mean()) << name;
      for (std::size_t i = 0; i < one.runs.size(); ++i) {
        EXPECT_GT(one.runs[i].error.mean(), 1.5 * observer.runs[i].error.mean()) << name << i;
      }
    }
  }
  EXPECT_LT(observer.error.mean(), 1);

  EXPECT_EQ(all.systems.size(), expected.size());
  EXPECT_THAT(steps, IsSupersetOf({"one line", "ihyp, all runs", "Preisach", "ihyp", "tests"}));
  EXPECT_THAT(shares, Each(AllOf(Ge(0), Le(1))));
  EXPECT_EQ(std::ranges::max(shares), shares.back());

  // The same run with a zero of its own: the same strain but for an offset, its errors around 0.
  EXPECT_THAT(all.free_zero, ElementsAre(false, false, true));
  for (const auto& [name, error] : expected) {
    const compare::Compared& one = named(all, name);
    EXPECT_NEAR(offset(one.runs[2].strain, one.runs[0].strain).max, 0, 1e-9) << name;
    std::vector<double> errors;
    for (std::size_t i = 0; i < spring.strain.size(); ++i) {
      const double e = one.runs[2].strain[i] - all.tests[2].strain[i];
      if (std::isfinite(e)) {
        errors.push_back(e);
      }
    }
    std::ranges::nth_element(errors, errors.begin() + std::ssize(errors) / 2);
    EXPECT_NEAR(errors[errors.size() / 2], 0, 1e-12) << name;
    EXPECT_LE(one.runs[2].error.mean(), one.runs[0].error.mean() + 1e-9)
        << name << ": no offset has a smaller mean than the median";
  }
}

/// With the wire's own heat balance, so that nothing but the relays is identified.
TEST(Compare, PreisachFollowsWhatItKnowsAndIsLostWhereTheHeatBalanceIsWrong) {
  const Wire<double> unit_a = files::load_wire(shipped("units/a.toml")).wire;
  const Runs training{trace("50MPa", 6), trace("150MPa", 60), trace("400MPa", 6),
                      trace("spring", 6)};
  const compare::System system = compare::preisach(
      {unit_a, 0, std::vector<double>(training.size(), room_K), room_K}, training);
  // Slices at 50, 100, 150, 250 (the spring's) and 400 MPa.
  EXPECT_EQ(system.parameters, 5 * (23 * 24 / 2 + 2) + 1);
  const auto mean_percent = [&](const smaservo::identify::Run& run) {
    const std::vector<double> strain = system.strain(run);
    double sum = 0;
    for (std::size_t i = 0; i < strain.size(); ++i) {
      sum += std::abs(strain[i] - run.strain[i]) / 0.04 * 100;
    }
    return sum / static_cast<double>(strain.size());
  };
  EXPECT_NEAR(mean_percent(training[1]), 1.38, 0.2);
  EXPECT_NEAR(mean_percent(training[3]), 0.67, 0.15);
  EXPECT_NEAR(mean_percent(trace("disturbed", 6)), 6.66, 0.7);
}

/// Runs of a wire that is simple enough to be identified in no time.
smaservo::identify::Run recorded_bath(double stress_MPa = 150) {
  const Recording r;
  return run_of({{"temperature_degC", r.temperature_degC},
                 {"strain_ref", r.strain},
                 {"stress_MPa", std::vector<double>(r.strain.size(), stress_MPa)}});
}

smaservo::identify::Run recorded_bath_with_resistance() {
  const Recording r;
  return run_of({{"temperature_degC", r.temperature_degC},
                 {"strain_ref", r.strain},
                 {"resistance_ohm", r.ohm},
                 {"stress_MPa", std::vector<double>(r.strain.size(), 150)}});
}

TEST(Compare, WhatARunLacksMakesASystemSilentInIt) {
  const auto from = files::load_wire("smartflex-76um");
  const auto with = recorded_bath_with_resistance();
  const auto without = recorded_bath(140);
  const compare::Comparison all =
      compare::compare(from, {with, recorded_bath(160)}, {without, with}, 1, no_progress);
  for (const char* name : {"one line", "polynomial", "two lines", "stress-strain-resistance"}) {
    const compare::Compared& one = named(all, name);
    ASSERT_EQ(one.runs.size(), 2U) << one.system.remark;
    EXPECT_EQ(one.runs[0].error.count(), 0U) << name;
    EXPECT_EQ(one.runs[0].strain.size(), without.strain.size());
    EXPECT_EQ(one.runs[1].error.count(), with.strain.size()) << name;
  }
  EXPECT_THAT(named(all, "stress-strain-resistance").system.remark,
              HasSubstr("not used, having no resistance: "));
  EXPECT_EQ(all.beyond[0].stress, 1) << "140 MPa, where 150 and 160 MPa are known";
  EXPECT_EQ(all.beyond[0].resistance, 0) << "it has none";
  EXPECT_EQ(all.beyond[1].stress + all.beyond[1].resistance, 0) << "one of the training";
  EXPECT_EQ(named(all, "ihyp observer").error.count(), 0U) << "it needs power";
  for (const char* name : {"Duhem", "Liang-Rogers", "ihyp"}) {
    EXPECT_EQ(named(all, name).runs[0].error.count(), without.strain.size());
    EXPECT_LT(named(all, name).error.mean(), 10) << name;
  }
}

/// A zero of its own is no reason to take a wire for one that is 4 % shorter.
TEST(Compare, ADisplacementIsPutWhereTheTypeIsLongest) {
  const auto from = files::load_wire("smartflex-76um");
  const auto run = recorded_bath();
  const auto other = recorded_bath(140);
  const compare::Comparison absolute = compare::compare(from, {run}, {other}, 1, no_progress);
  const compare::Comparison free =
      compare::compare(from, {displaced(run)}, {other}, 1, no_progress);
  for (const char* name : {"Duhem", "Liang-Rogers", "ihyp"}) {
    const auto& strain = named(free, name).runs[0].strain;
    const Offset apart = offset(strain, named(absolute, name).runs[0].strain);
    EXPECT_NEAR(apart.mean, 0, 0.002) << name;
    EXPECT_LT(apart.max, 0.002) << name;
  }
}

TEST(Compare, WhatItCannotUseIsRefusedByName) {
  const auto good = recorded_bath();
  auto settled = good;
  settled.name = "settled.csv";
  settled.kind = identify::RunKind::settled;
  EXPECT_EQ(refusal({settled}, {good}),
            "settled.csv: is a settled run; compare takes runs of Joule heating or in a bath");
  EXPECT_EQ(refusal({good}, {settled}), refusal({settled}, {good}));
  auto blind = good;
  blind.name = "blind.csv";
  blind.strain.clear();
  EXPECT_EQ(refusal({good}, {blind}),
            "blind.csv: has no strain_ref or displacement, which compare needs");
}

}  // namespace
}  // namespace smaservo::test
