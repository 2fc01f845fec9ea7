// Parameters that a fit reports as kept have the values from before the fit, to the last bit, and
// no transition temperature falls with stress, whatever the runs are. The wires are random; the
// runs of them are random and tell little.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <map>
#include <random>

#include "host-sim/identify/fit/fit.hpp"
#include "host-sim/identify/fit/parameters.hpp"
#include "host-sim/identify/fitted_wire.hpp"
#include "model/files/wire/wire_file.hpp"
#include "model/wire/wire_parameters.hpp"
#include "tests/host-sim/identify/simulated_runs.hpp"

namespace smaservo::test {
namespace {

using ::testing::HasSubstr;

/// A wire as others of its kind are, somewhat off in every parameter.
Wire<double> another(const Wire<double>& type, std::mt19937_64& random) {
  std::normal_distribution<double> normal(0, 0.6);
  return identify::vary_wire<double>(type, {}, [&](const identify::FitParameter& parameter) {
    return parameter.value(normal(random));
  });
}

/// Runs that tell little: one load, one heating, a narrow bath, a calorimeter alone, or two loads
/// that hardly differ.
std::vector<identify::Run> thin_runs(const Wire<double>& wire, std::mt19937_64& random) {
  const double stress_Pa =
      wire.limits.stress_Pa * std::uniform_real_distribution<double>(0.05, 1)(random);
  std::vector<double> path = cycle_K();
  switch (random() % 5) {
    case 0:
      return {bath_run(wire, stress_Pa, random)};
    case 1:
      path.resize(path.size() / 2);
      return {bath_run(wire, stress_Pa, random, path)};
    case 2:
      std::erase_if(path, [](double T) { return T < 301 || T > 352; });
      return {bath_run(wire, stress_Pa, random, path)};
    case 3:
      return {calorimetry_run(wire, random)};
    default:
      return {bath_run(wire, stress_Pa, random), bath_run(wire, 0.95 * stress_Pa, random)};
  }
}

/// The lowest slopes of start and finish, K/MPa, at many stresses of the wire's range.
std::map<std::string, double> lowest_slopes(const Wire<double>& wire) {
  std::map<std::string, double> lowest;
  const auto& rows = wire_parameters<double>;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const std::string path(rows[i].path.text());
    if (rows[i].coefficients != 3 || !rows[i].is_used(wire)) {
      continue;
    }
    double& slope = lowest[path] = 1e9;
    for (int k = 0; k <= 50; ++k) {
      const double stress_Pa = wire.limits.stress_Pa * k / 50;
      slope =
          std::min(slope, 1e6 * (rows[i + 1].get(wire) + 2 * stress_Pa * rows[i + 2].get(wire)));
    }
  }
  return lowest;
}

/// The numbers of one process or table, as the wire has them.
std::vector<double> numbers_of(const Wire<double>& wire, const std::string& group) {
  std::vector<double> all;
  for (const WireParameter<double>& row : wire_parameters<double>) {
    if (row.path.text().starts_with(group + ".") && row.is_used(wire)) {
      all.push_back(row.get(wire));
    }
  }
  return all;
}

TEST(IdentifyKept, ThinRunsKeepWhatTheySayAndNoTransitionFalls) {
  std::mt19937_64 random(11);
  identify::FitOptions options;
  options.variants = false;
  std::size_t kept = 0, determined = 0;
  for (int round = 0; round < 20; ++round) {
    const files::WireDescription from =
        files::load_wire(round % 2 == 0 ? "smartflex-76um" : "flexinol-lt-0.15mm");
    const Wire<double> truth = another(from.wire, random);
    const identify::FitResult fit =
        identify::fit_wire(from.wire, thin_runs(truth, random), options);
    SCOPED_TRACE(fmt::format("round {}, {}", round, fit.runs.front().name));
    std::map<std::string, bool> moved;
    for (const identify::FittedParameter& fitted : fit.parameters) {
      bool& group = moved[identify::group_of(fitted.parameter.key)];
      group = group || fitted.determined;
      ++(fitted.determined ? determined : kept);
      if (!fitted.determined) {
        EXPECT_EQ(fitted.value, fitted.parameter.prior) << fitted.parameter.key;
      }
    }
    for (const auto& [group, has_moved] : moved) {
      if (!has_moved && identify::is_of_process(group)) {
        EXPECT_EQ(numbers_of(fit.wire, group), numbers_of(from.wire, group)) << group;
      }
    }
    for (const auto& [path, slope] : lowest_slopes(fit.wire)) {
      EXPECT_GE(slope, 0) << path;
    }
  }
  EXPECT_GT(determined, 100U);
  EXPECT_GT(kept, 200U);
}

/// Two cycles' outer curves, and loops within them.
std::vector<double> loops_K() {
  std::vector<double> all = cycle_K();
  double T = all.back();
  for (const double goal : {338.0, 310.0, 352.0, 318.0, 345.0, 322.0, 349.0, 314.0, 400.0, 293.0}) {
    for (; std::abs(T - goal) > 0.6; T += T < goal ? 0.5 : -0.5) {
      all.push_back(T);
    }
  }
  return all;
}

TEST(IdentifyOrdered, FindsTheEndsAndTheOrderOfTheLoops) {
  std::mt19937_64 random(44);
  const files::WireDescription from = files::load_wire("smartflex-76um");
  Wire<double> truth = another(from.wire, random);
  truth.kinetics.smallest_reversal_K = 0;
  truth.kinetics.loop_odds = 12;
  truth.kinetics.m2a.taper = 0.6;
  truth.kinetics.a2m_a2r.taper = Pair<double>(1.5, 0.1);
  const std::vector<identify::Run> runs = {bath_run(truth, 50e6, random, loops_K()),
                                           bath_run(truth, 150e6, random, loops_K()),
                                           bath_run(truth, 300e6, random, loops_K())};
  identify::FitOptions options;
  options.variants = false;
  const identify::FitResult paper = identify::fit_wire(from.wire, runs, options);
  options.structure = identify::Structure::ordered;
  const identify::FitResult ordered = identify::fit_wire(from.wire, runs, options);
  const auto rms = [](const identify::FitResult& fit) {
    double sum = 0;
    for (const identify::FittedRun& run : fit.runs) {
      sum += run.strain.rms * run.strain.rms;
    }
    return std::sqrt(sum / static_cast<double>(fit.runs.size()));
  };
  std::printf(
      "error of the fit: %.4f %% with paper 000's, %.4f %% ordered; odds %.2f, tapers %.2f %.2f\n",
      100 * rms(paper), 100 * rms(ordered), ordered.wire.kinetics.loop_odds,
      ordered.wire.kinetics.m2a.taper, ordered.wire.kinetics.a2m_a2r.taper.first());
  EXPECT_EQ(paper.wire.kinetics.loop_odds, 1);
  EXPECT_EQ(paper.wire.kinetics.m2a.taper, 0);
  EXPECT_LT(rms(ordered), 0.2 * rms(paper));
  EXPECT_NEAR(ordered.wire.kinetics.loop_odds, 12, 1.2);
  EXPECT_NEAR(ordered.wire.kinetics.m2a.taper, 0.6, 0.15);
  EXPECT_NEAR(ordered.wire.kinetics.a2m_a2r.taper.first(), 1.5, 0.4);
}

TEST(IdentifyKept, OneLoadLeavesTheSlopesAlone) {
  const files::WireDescription from = files::load_wire("flexinol-lt-0.15mm");
  std::mt19937_64 random(12);
  const Wire<double> truth = another(from.wire, random);
  identify::FitOptions options;
  options.variants = false;
  const identify::FitResult fit =
      identify::fit_wire(from.wire, {bath_run(truth, 100e6, random)}, options);
  for (const identify::FittedParameter& fitted : fit.parameters) {
    const std::string& key = fitted.parameter.key;
    if (key.ends_with("_stress") || key.ends_with("_bend")) {
      EXPECT_FALSE(fitted.determined) << key;
    }
    if (key == "wire.m2a.temperature" || key == "wire.a2m.temperature") {
      EXPECT_TRUE(fitted.determined) << key;
      EXPECT_GT(fitted.sd, 1) << "the slope, which is kept, may be off by what it usually is";
    }
  }
  EXPECT_LT(fit.runs.front().strain.rms, 0.01);
  const std::string text = files::to_toml(identify::fitted_wire(from, fit, "w"));
  EXPECT_THAT(text, HasSubstr("temperature from 73.5 to "));
}

/// A wire with surfaces of its own for all processes. The start and finish of A2R do not move with
/// stress, as in all presets: noise alone decides whether the runs ask for a fall.
Wire<double> whose_a2r_stays(const Wire<double>& type, std::mt19937_64& random) {
  std::normal_distribution<double> normal(0, 0.6);
  return identify::vary_wire<double>(
      type, {.separate_r2a = true, .separate_r2m = true},
      [&](const identify::FitParameter& parameter) {
        const double u = normal(random);
        const bool stays = parameter.key.starts_with("wire.a2r") &&
                           (parameter.key.ends_with("_stress") || parameter.key.ends_with("_bend"));
        return parameter.value(stays ? 0 : u);
      });
}

/// The standard deviation of the difference of two runs' strains. A constant offset does not count,
/// as the zero of strain is not known.
double differ(const identify::Run& a, const identify::Run& b) {
  double sum = 0, squares = 0;
  for (std::size_t i = 0; i < a.strain.size(); ++i) {
    const double d = a.strain[i] - b.strain[i];
    sum += d;
    squares += d * d;
  }
  const auto n = static_cast<double>(a.strain.size());
  return std::sqrt(std::max(0.0, squares / n - sum * sum / n / n));
}

/// Forbidding a fall with stress makes nothing else less accurate: the wire that is returned has
/// the structure that was found, and moves as the runs do.
TEST(IdentifyKept, ATransitionThatStaysIsFound) {
  const Wire<double> from = files::load_wire("smartflex-76um").wire;
  std::mt19937_64 random(14);
  int separated = 0;
  for (int round = 0; round < 4; ++round) {
    const Wire<double> truth = whose_a2r_stays(from, random);
    const std::vector<double> stresses_Pa{10e6, 60e6, 150e6, 250e6, 380e6};
    std::vector<identify::Run> runs;
    for (const double stress_Pa : stresses_Pa) {
      runs.push_back(bath_run(truth, stress_Pa, random));
    }
    SCOPED_TRACE(fmt::format("round {}", round));
    const identify::FitResult fit = identify::fit_wire(from, runs, {});
    separated += fit.wire.kinetics.separate_r2a + fit.wire.kinetics.separate_r2m;
    EXPECT_EQ(fit.wire.kinetics.separate_r2a, fit.variant.separate_r2a);
    EXPECT_EQ(fit.wire.kinetics.separate_r2m, fit.variant.separate_r2m);
    for (std::size_t i = 0; i < runs.size(); ++i) {
      EXPECT_LT(differ(bath_run(fit.wire, stresses_Pa[i], random), runs[i]), 1e-4)
          << stresses_Pa[i];
    }
    const Surface<double> a2r = second_surface(fit.wire.kinetics.a2m_a2r);
    const Surface<double> is = second_surface(truth.kinetics.a2m_a2r);
    EXPECT_NEAR(a2r.start_K[0], is.start_K[0], 0.5);
    EXPECT_NEAR(a2r.finish_K[0], is.finish_K[0], 0.5);
  }
  EXPECT_GT(separated, 0);
}

TEST(IdentifyKept, AWireWhoseTransitionsFallIsNoStart) {
  std::mt19937_64 random(13);
  Wire<double> from = files::load_wire("smartflex-76um").wire;
  from.kinetics.m2a.start_K[1] = -1e-9;
  try {
    identify::fit_wire(from, {bath_run(from, 100e6, random)}, {});
    FAIL();
  } catch (const std::exception& error) {
    EXPECT_THAT(error.what(), HasSubstr("wire.m2a: its start or finish temperature falls"));
  }
}

}  // namespace
}  // namespace smaservo::test
