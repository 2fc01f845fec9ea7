// The model as the fit runs it: the same wire as the observers', with exact derivatives.

#include <algorithm>
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

/// The same under a load that varies.
identify::FitRun run_under_varying_load() {
  identify::FitRun varying = run();
  for (std::size_t i = 0; i < varying.stress_Pa.size(); ++i) {
    varying.stress_Pa[i] *= 1 + 0.4 * std::sin(0.9 * static_cast<double>(i) * step_s);
  }
  return varying;
}

template <class T>
identify::Assumed<T> assumed(std::size_t by, const T& deviation,
                             const identify::FitVariant& variant = {}) {
  std::size_t at = 0;
  return {identify::vary_wire<T>(wire(), variant,
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
  identify::predict(run, plain, identify::path_of(run, plain), all);
  return all;
}

/// With the derivatives by parameter `by`, as number 0.
std::vector<identify::Predicted<identify::Jet>> with_derivatives(const identify::FitRun& run,
                                                                 std::size_t by) {
  std::vector<identify::Predicted<identify::Jet>> all;
  identify::predict(run, assumed(by, identify::Jet(0.0, 0)),
                    identify::path_of(run, assumed(by, 0.0)), all);
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
  const std::vector<identify::Predicted<identify::Jet>> jets = with_derivatives(run_, 0);
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
    const std::vector<identify::Predicted<identify::Jet>> jets = with_derivatives(run_, k);
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

/// A step of the kinetics in two: one to the plain temperature, which shows how far the heat
/// balance depends on the parameters; and one from the same state to where the temperature depends
/// on them.
class InTwoSteps {
 public:
  using K = ThreePhase<identify::Jet>;

  InTwoSteps(const Plant<K>::Params& params, const Drive<identify::Jet>& start)
      : params_(params), state_(K::rest(params.kinetics, start)) {}

  void advance(const identify::BalancedStep& plain, const PlantInput<identify::Jet>& in,
               double dt_s) {
    using identify::Jet;
    const ThermalBody<Jet>& body = params_.body;
    const Jet before_K = K::drive(state_).temperature_K;
    const Jet above = before_K - in.ambient_K;
    const Jet heat_J = heat_J_ + (in.power_W - body.loss_W(above)) * Jet(dt_s);
    const Jet plain_J_K = body.capacity_J_K + Jet(0.5) * body.loss_slope_W_K(above) * Jet(dt_s);
    const Phases<Jet> z = K::phases(state_);
    const auto rest_J = [&](const Jet& to_K, const Phases<Jet>& to) {
      return heat_J - plain_J_K * (to_K - before_K) +
             body.latent_m2a_J * (to.martensite - z.martensite) +
             body.latent_r2a_J * (to.r_phase - z.r_phase);
    };
    K::State trial = state_;
    const Jet there_K(plain.temperature_K);
    K::advance(params_.kinetics, trial, {there_K, in.stress_Pa});
    Jet missing_J = rest_J(there_K, K::phases(trial));
    missing_J.a = 0;
    const Jet goal_K = there_K + missing_J / Jet(plain.capacity_J_K);
    K::advance(params_.kinetics, state_, {goal_K, in.stress_Pa});
    heat_J_ = rest_J(goal_K, K::phases(state_));
  }
  Phases<identify::Jet> phases() const { return K::phases(state_); }

 private:
  Plant<K>::Params params_;
  K::State state_;
  identify::Jet heat_J_{0.0};
};

/// With all surfaces, tapers and an order of the loops, under a load that varies.
TEST(Prediction, OneStepHasTheDerivativesOfTwo) {
  const identify::FitVariant variant{
      .separate_r2a = true, .separate_r2m = true, .taper = true, .loop_order = true};
  const identify::FitRun run_ = run_under_varying_load();
  const identify::Path path = identify::path_of(run_, assumed(0, 0.0, variant));
  const std::size_t count = identify::fit_parameters(wire(), variant).size();
  for (std::size_t k = 0; k < count; ++k) {
    const auto jets = assumed(k, identify::Jet(0.0, 0), variant);
    const auto params = identify::plant_of(run_.kind, jets);
    const identify::Acting<identify::Jet> acting{run_, jets};
    const Drive<identify::Jet> start{jets.here.ambient_K, acting.at(0).stress_Pa};
    identify::FollowingPlant<identify::Jet> one(params, start);
    InTwoSteps two(params, start);
    double greatest = 0;
    double difference = 0;
    for (std::size_t i = 0; i < 1000; ++i) {
      one.advance(path.steps[i], acting.at(i), run_.dt_s[i]);
      two.advance(path.steps[i], acting.at(i), run_.dt_s[i]);
      const Phases<identify::Jet> a = ThreePhase<identify::Jet>::phases(one.state());
      const Phases<identify::Jet> b = two.phases();
      ASSERT_EQ(a.martensite.a, b.martensite.a);
      ASSERT_EQ(a.r_phase.a, b.r_phase.a);
      greatest = std::max({greatest, std::abs(b.martensite.v[0]), std::abs(b.r_phase.v[0])});
      difference = std::max({difference, std::abs(a.martensite.v[0] - b.martensite.v[0]),
                             std::abs(a.r_phase.v[0] - b.r_phase.v[0])});
    }
    EXPECT_LE(difference, 1e-9 * greatest) << "parameter " << k;
  }
}

}  // namespace
}  // namespace smaservo::test
