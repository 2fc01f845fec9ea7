#include "host-sim/papers/figures/003/temperature_loop.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include "model/wire/plant.hpp"

namespace smaservo::figures {

FixedController::FixedController(const LoopDesign& design, double response_s)
    : design_(design),
      gain_W_K_(design.capacity_J_K / response_s),
      integral_time_s_(design.capacity_J_K / design.loss_W_K),
      derivative_time_s_(design.sample_s),
      filtered_K_(design.ambient_K),
      filtered_before_K_(design.ambient_K) {}

double FixedController::power_W(double measured_K, double next_K) {
  filtered_before_K_ = filtered_K_;
  filtered_K_ += 0.5 * (measured_K - filtered_K_);
  const double error_K = next_K - measured_K;
  const double rate_K_s = (filtered_K_ - filtered_before_K_) / design_.sample_s;
  const double wanted_W = gain_W_K_ * (error_K - derivative_time_s_ * rate_K_s) + integral_W_;
  const double power_W = std::clamp(wanted_W, 0.0, design_.max_W);
  const bool inwards = (wanted_W > power_W) != (error_K > 0);
  if (wanted_W == power_W || inwards) {
    integral_W_ += gain_W_K_ * error_K * design_.sample_s / integral_time_s_;
  }
  return power_W;
}

RecursiveLeastSquares::RecursiveLeastSquares(const Vector& start, double start_variance,
                                             double forgetting, double largest_trace)
    : parameters_(start),
      covariance_(start_variance * Eigen::Matrix4d::Identity()),
      forgetting_(forgetting),
      largest_trace_(largest_trace) {}

void RecursiveLeastSquares::update(const Vector& regressors, double y) {
  const Vector spread = covariance_ * regressors;
  const Vector gain = spread / (forgetting_ + regressors.dot(spread));
  parameters_ += gain * (y - regressors.dot(parameters_));
  covariance_ -= gain * spread.transpose();
  if (covariance_.trace() < forgetting_ * largest_trace_) {
    covariance_ /= forgetting_;
  }
  covariance_ = 0.5 * (covariance_ + covariance_.transpose()).eval();
}

AdaptiveController::AdaptiveController(const LoopDesign& design, const AdaptiveSettings& settings)
    : design_(design), settings_(settings) {
  // Starts with the parameters of the design; the second pole and the offset are estimated later.
  const double a = std::exp(-design.sample_s * design.loss_W_K / design.capacity_J_K);
  const double b = (1 - a) * design.max_W / design.loss_W_K / 10;
  const RecursiveLeastSquares start({a, 0, b, 0}, 1e-3, settings.forgetting, 100);
  regions_.assign(settings.region_edges_K.size() + 1, start);
}

double AdaptiveController::power_W(double measured_K, double next_K) {
  const double y = scaled(measured_K);
  if (predicting_) {
    regions_[*predicting_].update(regressors_, y);
  } else {
    before_ = y;
  }
  predicting_ = region(measured_K);
  const auto& theta = regions_[*predicting_].parameters();
  // Heating a wire makes it warmer, so b has a positive lower bound.
  const double b = std::max(theta[2], 1e-3);
  const double unheated = theta[0] * y + theta[1] * before_ + theta[3];
  const double wanted = (b * (scaled(next_K) - unheated) + settings_.change_weight * power_) /
                        (b * b + settings_.change_weight);
  power_ = std::clamp(wanted, 0.0, 1.0);
  regressors_ = {y, before_, power_, 1};
  before_ = y;
  return power_ * design_.max_W;
}

std::size_t AdaptiveController::region(double temperature_K) const {
  const auto above = std::ranges::upper_bound(settings_.region_edges_K, temperature_K);
  return static_cast<std::size_t>(above - settings_.region_edges_K.begin());
}

double AdaptiveController::scaled(double temperature_K) const {
  return (temperature_K - design_.ambient_K) / 10;
}

LoopDesign loop_design(const LoopSetup& setup) {
  const auto body = thermal_body(setup.wire.geometry, setup.wire.heat);
  const double ohm = cold_resistance_ohm(setup.wire);
  const double middle_K = 40;  // temperature above ambient at which the slope of the loss is taken
  return {setup.sample_s, setup.limit_A * setup.limit_A * ohm, body.capacity_J_K,
          body.loss_slope_W_K(middle_K), setup.ambient_K};
}

std::vector<LoopRow> run_loop(const LoopSetup& setup, TemperatureController& controller,
                              const std::vector<LoopReference>& references) {
  using Model = Plant<ThreePhase<double>>;
  const auto params = plant_params(setup.wire);
  std::mt19937_64 random(setup.seed);
  std::normal_distribution<double> normal;
  double stress_Pa = references.front().stress_Pa;
  auto state = Model::rest(params, {setup.ambient_K, stress_Pa});
  constexpr int steps_per_sample = 20;
  const double step_s = setup.sample_s / steps_per_sample;
  std::vector<LoopRow> rows;
  for (const LoopReference& next : references) {
    const double measured_K = Model::temperature_K(state) + setup.noise_K * normal(random);
    const double asked_W = controller.power_W(measured_K, next.temperature_K);
    const double ohm = Model::resistance_ohm(params, state, setup.ambient_K);
    const double current_A = std::min(std::sqrt(asked_W / ohm), setup.limit_A);
    for (int i = 0; i < steps_per_sample; ++i) {
      stress_Pa += (next.stress_Pa - stress_Pa) * step_s / setup.stress_lag_s;
      const double power_W =
          current_A * current_A * Model::resistance_ohm(params, state, setup.ambient_K);
      Model::advance(params, state, {power_W, stress_Pa, setup.ambient_K}, step_s);
    }
    rows.push_back({static_cast<double>(rows.size() + 1) * setup.sample_s,
                    next,
                    {Model::temperature_K(state), stress_Pa},
                    current_A});
  }
  return rows;
}

double tracking_error_K(const std::vector<LoopRow>& rows, double skipped_s) {
  double squares = 0;
  std::size_t count = 0;
  for (const LoopRow& row : rows) {
    if (row.time_s > skipped_s) {
      squares += std::pow(row.truth.temperature_K - row.reference.temperature_K, 2);
      ++count;
    }
  }
  return std::sqrt(squares / static_cast<double>(count));
}

}  // namespace smaservo::figures
