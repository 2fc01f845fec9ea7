// The choice of a structure by runs that are left out of a fit, and what the observer is told of
// its accuracy.

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <numeric>
#include <random>
#include <vector>

#include "host-sim/identify/fit/fit.hpp"
#include "host-sim/identify/fit/judge/observed_run.hpp"
#include "model/files/wire/wire_file.hpp"
#include "tests/host-sim/identify/simulated_runs.hpp"

namespace smaservo::test {
namespace {

const Wire<double>& type() {
  static const Wire<double> one = files::load_wire("smartflex-76um").wire;
  return one;
}

/// Another piece of this wire, with a transition that is 2 K off.
Wire<double> piece() {
  Wire<double> wire = type();
  for (double* temperature_K : {&wire.kinetics.m2a.start_K[0], &wire.kinetics.m2a.finish_K[0]}) {
    *temperature_K += 2;
  }
  return wire;
}

/// The same with ends and inner loops that are not paper 000's.
Wire<double> ordered_piece() {
  Wire<double> wire = piece();
  wire.kinetics.loop_odds = 12;
  wire.kinetics.m2a.taper = 1;
  wire.kinetics.a2m_a2r.taper = Pair<double>(1.5, 0.1);
  return wire;
}

std::vector<identify::Run> runs_of(const Wire<double>& wire,
                                   const std::vector<double>& stresses_MPa) {
  std::mt19937_64 random(44);
  std::vector<identify::Run> runs;
  runs.reserve(stresses_MPa.size());
  for (const double stress_MPa : stresses_MPa) {
    runs.push_back(joule_run(wire, 1e6 * stress_MPa, random));
  }
  return runs;
}

/// Without the search for other surfaces, and with few iterations: the fits need not be good ones.
identify::FitResult fitted(const std::vector<identify::Run>& runs,
                           identify::Structure structure = identify::Structure::automatic,
                           int max_iterations = 18) {
  identify::FitOptions options;
  options.structure = structure;
  options.variants = false;
  options.max_iterations = max_iterations;
  return identify::fit_wire(type(), runs, options);
}

TEST(IdentifyChoice, AWireWithAnOrderGetsOne) {
  const std::vector<identify::Run> runs = runs_of(ordered_piece(), {400, 50, 200, 100});
  const identify::FitResult fit = fitted(runs);
  const identify::Judgement& judgement = fit.judgement;
  EXPECT_EQ(judgement.runs, (std::vector<std::size_t>{1, 3, 2, 0})) << "by rising stress";
  ASSERT_EQ(judgement.structures.size(), 2U);
  EXPECT_EQ(judgement.structures[0].structure, identify::Structure::paper_000);
  EXPECT_EQ(judgement.structures[1].structure, identify::Structure::ordered);
  EXPECT_EQ(judgement.chosen(), identify::Structure::ordered);
  EXPECT_TRUE(fit.variant.taper && fit.variant.loop_order);
  EXPECT_GT(fit.wire.kinetics.loop_odds, 4);
  const auto errors = [&](std::size_t structure) {
    return identify::mean_error(judgement.structures[structure].unseen);
  };
  std::printf("observer in the runs left out: %.2f %% with paper 000, %.2f %% ordered\n",
              100 * errors(0), 100 * errors(1));
  EXPECT_LT(errors(1), 0.9 * errors(0));
  EXPECT_GT(fit.wire.accuracy.strain, fit.strain_sd) << "what was left without the order";
}

TEST(IdentifyChoice, AWireOfPaper000StaysOne) {
  const std::vector<identify::Run> runs = runs_of(piece(), {50, 100, 200, 400});
  const identify::FitResult fit = fitted(runs);
  EXPECT_EQ(fit.judgement.chosen(), identify::Structure::paper_000);
  EXPECT_FALSE(fit.variant.taper || fit.variant.loop_order);
  EXPECT_EQ(fit.wire.kinetics.loop_odds, 1);
  EXPECT_EQ(fit.wire.kinetics.m2a.taper, 0);
  // What was tried and given up leaves no trace.
  const identify::FitResult forced = fitted(runs, identify::Structure::paper_000);
  EXPECT_EQ(forced.judgement.structures.size(), 1U);
  EXPECT_EQ(forced.wire.kinetics.m2a.start_K[0], fit.wire.kinetics.m2a.start_K[0]);
  EXPECT_EQ(forced.wire.accuracy.strain, fit.wire.accuracy.strain);
}

TEST(IdentifyChoice, ThreeRunsAreTooFew) {
  const identify::FitResult fit =
      fitted(runs_of(ordered_piece(), {50, 100, 400}), identify::Structure::automatic, 2);
  EXPECT_TRUE(fit.judgement.runs.empty());
  EXPECT_TRUE(fit.judgement.structures.empty());
  EXPECT_FALSE(fit.variant.taper || fit.variant.loop_order);
  EXPECT_EQ(fit.wire.accuracy.strain, fit.strain_sd);
}

TEST(IdentifyChoice, OneThatIsForcedIsJudgedAlone) {
  const identify::FitResult fit =
      fitted(runs_of(piece(), {50, 100, 200, 400}), identify::Structure::ordered, 6);
  EXPECT_TRUE(fit.variant.taper && fit.variant.loop_order);
  EXPECT_EQ(fit.judgement.structures.size(), 1U);
  EXPECT_EQ(fit.judgement.chosen(), identify::Structure::ordered);
  EXPECT_GE(fit.wire.accuracy.strain, fit.strain_sd);
}

TEST(ObservedRun, HasTheWholeTimeAndEnergyOfTheRun) {
  std::mt19937_64 random(3);
  identify::Run run = joule_run(type(), 100e6, random);
  const auto sum = [](const std::vector<double>& values) {
    return std::accumulate(values.begin(), values.end(), 0.0);
  };
  for (const double row_s : {0.001, 0.02}) {
    for (std::size_t i = 0; i < run.time_s.size(); ++i) {
      run.time_s[i] = row_s * static_cast<double>(i);
    }
    const identify::ObservedRun seen =
        identify::observed_run(run, {type(), {0, 1.25}, {room_K, 1, 0.001, 1, 1, 0}});
    EXPECT_NEAR(sum(seen.dt_s), run.time_s.back(), 1e-9);
    EXPECT_LT(std::ranges::max(seen.dt_s), std::max(row_s, 0.005) + 1e-9);
    EXPECT_GT(std::ranges::min(seen.dt_s), std::min(row_s, 0.004) - 1e-9);
    double energy_J = 0, measured_J = 0;
    for (std::size_t i = 0; i < seen.dt_s.size(); ++i) {
      energy_J += seen.dt_s[i] * seen.seen[i].power_W;
    }
    for (std::size_t i = 1; i < run.time_s.size(); ++i) {
      measured_J += row_s * run.current_A[i] * run.voltage_V[i];
    }
    EXPECT_NEAR(energy_J, measured_J, 1e-9 * measured_J);
    EXPECT_EQ(seen.strain.back(), run.strain.back() - 0.001);
    EXPECT_NEAR(seen.seen.back().stress_Pa, run.stress_Pa.back() / 1.25, 1);
  }
}

/// With the wire that made the run the observer errs by little, with another one by more.
TEST(ObservedRun, TellsTheRightWireFromAnother) {
  std::mt19937_64 random(4);
  const identify::Run run = joule_run(ordered_piece(), 100e6, random);
  const auto error = [&](const Wire<double>& wire) {
    const identify::ObservedRun seen =
        identify::observed_run(run, {wire, {0, 1}, {room_K, 1, 0, 1, 1, 0}});
    return identify::observer_errors(seen, wire);
  };
  const identify::ObserverErrors right = error(ordered_piece());
  EXPECT_NEAR(static_cast<double>(right.count), 4 * 1150, 4) << "four starts, after a second";
  EXPECT_LT(right.mean() / 0.04, 0.01);
  EXPECT_GT(right.share_within_2_sd(), 0.9);
  EXPECT_GT(error(piece()).mean(), 1.5 * right.mean());
}

}  // namespace
}  // namespace smaservo::test
