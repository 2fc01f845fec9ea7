// The model as the fit runs it: the same wire as the observers', with exact derivatives.

#include <cmath>
#include <gtest/gtest.h>
#include <numbers>

#include "host-sim/identify/fit/cost/prediction.hpp"
#include "host-sim/identify/fit/parameters.hpp"
#include "model/files/wire/wire_file.hpp"

namespace smaservo::test {
namespace {

constexpr double step_s = 8e-3;
constexpr double stress_Pa = 120e6;

const Wire<double>& wire() {
  static const Wire<double> one = files::load_wire("smartflex-76um").wire;
  return one;
}

/// A power that heats and cools the wire by varying amounts.
double power_W(double time_s) {
  const double wave = std::sin(2 * std::numbers::pi * time_s / 2.5);
  return 0.45 * (0.5 + 0.5 * wave) * (0.6 + 0.4 * std::sin(time_s));
}

identify::FitRun run() {
  identify::FitRun run;
  run.kind = identify::RunKind::joule;
  for (std::size_t i = 0; i < 2500; ++i) {
    run.dt_s.push_back(step_s);
    run.power_W.push_back(power_W(static_cast<double>(i) * step_s));
    run.current2_A2.push_back(0);
    run.stress_Pa.push_back(stress_Pa);
    if (i % 10 == 9) {
      run.after.push_back(i);
    }
  }
  return run;
}

template <class T>
identify::Assumed<T> assumed(std::size_t by, const T& deviation) {
  std::size_t at = 0;
  return {identify::vary_wire<T>(wire(), {},
                                 [&](const identify::FitParameter& parameter) {
                                   return parameter.value(at++ == by ? deviation : T(0.0));
                                 }),
          {T(0), T(1)},
          {T(room_K), T(1), T(0), T(1), T(1), T(0)}};
}

std::vector<identify::Predicted<double>> predicted(const identify::FitRun& run, std::size_t by,
                                                   double deviation) {
  const identify::Assumed<double> plain = assumed(by, deviation);
  std::vector<identify::Predicted<double>> all;
  identify::predict(run, plain, plain, all);
  return all;
}

TEST(Prediction, IsThatOfThePlantInSmallSteps) {
  using Reference = Plant<ThreePhase<double>>;
  const identify::FitRun run_ = run();
  const auto params = plant_params(wire());
  auto state = Reference::rest(params, {room_K, stress_Pa});
  const std::vector<identify::Predicted<double>> fit = predicted(run_, 0, 0);
  std::size_t at = 0;
  double worst = 0;
  constexpr int parts = 64;
  for (std::size_t i = 0; i < run_.power_W.size(); ++i) {
    for (int part = 0; part < parts; ++part) {
      Reference::advance(params, state, {run_.power_W[i], stress_Pa, room_K}, step_s / parts);
    }
    if (run_.after[at] == i) {
      worst = std::max(worst, std::abs(Reference::strain(params, state) - fit[at].strain));
      ++at;
    }
  }
  RecordProperty("worst_percent_of_stroke", std::to_string(100 * worst / wire().nominal_stroke));
  EXPECT_LT(worst, 0.004 * wire().nominal_stroke);
}

TEST(Prediction, HasTheSameValuesWithAndWithoutDerivatives) {
  const identify::FitRun run_ = run();
  const std::vector<identify::Predicted<double>> plain = predicted(run_, 0, 0);
  std::vector<identify::Predicted<identify::Jet>> jets;
  identify::predict(run_, assumed(0, identify::Jet(0.0, 0)), assumed(0, 0.0), jets);
  ASSERT_EQ(jets.size(), plain.size());
  for (std::size_t i = 0; i < plain.size(); ++i) {
    ASSERT_EQ(jets[i].strain.a, plain[i].strain);
    ASSERT_EQ(jets[i].resistance_ohm.a, plain[i].resistance_ohm);
  }
}

TEST(Prediction, DerivativesAreThoseOfFiniteDifferences) {
  const identify::FitRun run_ = run();
  const std::vector<identify::FitParameter> parameters = identify::fit_parameters(wire(), {});
  constexpr double h = 1e-4;
  for (std::size_t k = 0; k < parameters.size(); ++k) {
    const auto above = predicted(run_, k, h);
    const auto below = predicted(run_, k, -h);
    std::vector<identify::Predicted<identify::Jet>> jets;
    identify::predict(run_, assumed(k, identify::Jet(0.0, 0)), assumed(k, 0.0), jets);
    double difference = 0;
    double size = 0;
    for (std::size_t i = 0; i < jets.size(); ++i) {
      const double slope = (above[i].resistance_ohm - below[i].resistance_ohm) / (2 * h);
      difference += std::pow(slope - jets[i].resistance_ohm.v[0], 2);
      size += slope * slope;
    }
    // Where a threshold makes the path reverse, the difference quotient jumps, so a few comparisons
    // may be far off.
    EXPECT_LE(std::sqrt(difference), 0.05 * std::sqrt(size) + 1e-6) << parameters[k].key;
  }
}

}  // namespace
}  // namespace smaservo::test
