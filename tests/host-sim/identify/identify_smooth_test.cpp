// Wires that follow a tanh, whose tails fall faster than those of the preset's curve: the preset's
// curvature is ten times theirs. With a narrow prior of the curvature the fit would miss them. Its
// residuals would then look like few independent rows, and so give the prior still more weight.

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <random>
#include <string>

#include "host-sim/identify/classic.hpp"
#include "host-sim/identify/fit/fit.hpp"
#include "model/files/wire/wire_file.hpp"

namespace smaservo::test {
namespace {

/// One branch of a cycle: the martensite fraction around its centre.
struct Branch {
  double centre_K, width_K;

  double fraction(double T) const { return 1 / (1 + std::exp(2 * (T - centre_K) / width_K)); }
};

/// A run in a water bath, whose range of temperatures is often too small for a whole cycle. The
/// cooling branch is scaled to begin and end where the heating branch does.
identify::Run water_bath(const Branch& heating, const Branch& cooling, double stroke,
                         std::mt19937_64& random) {
  constexpr double cold_K = 301, hot_K = 352, step_K = 0.5;
  std::normal_distribution<double> noise(0, 2e-4);
  identify::Run run{};
  run.name = "water bath";
  run.kind = identify::RunKind::bath;
  const auto add = [&](double T, double fraction) {
    run.temperature_K.push_back(T);
    run.strain.push_back(stroke * fraction + noise(random));
    run.stress_Pa.push_back(100e6);
  };
  for (double T = cold_K; T < hot_K; T += step_K) {
    add(T, heating.fraction(T));
  }
  const double least = heating.fraction(hot_K), most = heating.fraction(cold_K);
  const double share = (most - least) / (cooling.fraction(cold_K) - cooling.fraction(hot_K));
  for (double T = hot_K; T > cold_K; T -= step_K) {
    add(T, least + share * (cooling.fraction(T) - cooling.fraction(hot_K)));
  }
  return run;
}

TEST(IdentifySmooth, FollowsATanh) {
  const Wire<double> from = files::load_wire("flexinol-lt-0.15mm").wire;
  std::mt19937_64 random(21);
  const auto between = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  identify::FitOptions options;
  options.variants = false;
  double sum = 0, tanh_sum = 0, worst = 0;
  for (int round = 0; round < 12; ++round) {
    const double stroke = between(0.035, 0.045);
    const double heating_K = between(328, 349);
    const identify::Run run = water_bath(
        {heating_K, between(2, 9)}, {heating_K - between(8, 22), between(2, 9)}, stroke, random);
    const double ours = from.nominal_stroke / stroke *
                        identify::fit_wire(from, {run}, options).runs.front().strain.rms;
    for (const identify::ClassicFit& classic : identify::fit_classics(run)) {
      if (classic.name == "tanh") {
        sum += ours;
        worst = std::max(worst, ours);
        tanh_sum += classic.rms;
        EXPECT_LT(ours, 0.02) << "round " << round;
      }
    }
  }
  RecordProperty("ours", std::to_string(100 * sum / 12));
  RecordProperty("worst", std::to_string(100 * worst));
  RecordProperty("tanh", std::to_string(100 * tanh_sum / 12));
  EXPECT_LT(sum, 2 * tanh_sum);
  EXPECT_GT(sum, 0.8 * tanh_sum);
}

}  // namespace
}  // namespace smaservo::test
