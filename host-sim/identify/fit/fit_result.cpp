// The remaining errors of a fit, and the standard deviations of its parameters.

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "host-sim/identify/fit/fit_state.hpp"

namespace smaservo::identify {
namespace {

/// The correlation length of neighbouring residuals in rows: 1 + 2 Σ ρ_k, up to the first ρ_k not
/// above 0.05.
double correlation_length(const std::vector<double>& residuals) {
  const std::size_t n = residuals.size();
  const auto product = [&](std::size_t lag) {
    double sum = 0;
    for (std::size_t i = lag; i < n; ++i) {
      sum += residuals[i] * residuals[i - lag];
    }
    return sum;
  };
  const double variance = product(0);
  double length = 1;
  for (std::size_t lag = 1; lag < n / 2 && variance > 0; ++lag) {
    const double rho = product(lag) / variance;
    if (rho <= 0.05) {
      break;
    }
    length += 2 * rho;
  }
  return length;
}

std::vector<double> differences(const std::vector<double>& model,
                                const std::vector<double>& measured, bool relative) {
  std::vector<double> all;
  for (std::size_t i = 0; i < model.size(); ++i) {
    const double d = model[i] - measured[i];
    if (!std::isnan(d)) {
      all.push_back(relative ? d / measured[i] : d);
    }
  }
  return all;
}

double rms(const std::vector<double>& x) {
  double sum = 0;
  for (const double value : x) {
    sum += value * value;
  }
  return x.empty() ? 0 : std::sqrt(sum / static_cast<double>(x.size()));
}

/// Mean square of the resistance's relative error. A comparison has less weight if it is less
/// certain how the resistance follows the strain.
double certain_square(const FittedRun& run, const Weights& weights) {
  double sum = 0;
  double share = 0;
  for (std::size_t i = 0; i < run.resistance_measured.size(); ++i) {
    const double measured = run.resistance_measured[i];
    if (std::isnan(measured)) {
      continue;
    }
    const double ambiguous = run.ambiguity[i] * weights.strain_sd / weights.resistance_sd;
    const double weight = 1 / (1 + ambiguous * ambiguous);
    sum += weight * std::pow(run.resistance_given_strain[i] / measured - 1, 2);
    share += weight;
  }
  return sum / share;
}

FitQuality quality(std::vector<double> errors, double scale) {
  FitQuality q;
  q.count = errors.size();
  if (errors.empty()) {
    return q;
  }
  q.rms = rms(errors) * scale;
  for (double& error : errors) {
    error = std::abs(error) * scale;
  }
  std::ranges::sort(errors);
  q.p95 = errors[static_cast<std::size_t>(0.95 * static_cast<double>(errors.size() - 1))];
  q.maximum = errors.back();
  return q;
}

/// Restores the earlier weights of a channel if their sum n/sd² over all runs was greater.
void keep_more(std::vector<Weights>& now, const std::vector<Weights>& before, double Weights::* sd,
               double Weights::* independent) {
  const auto information = [&](const std::vector<Weights>& weights) {
    double sum = 0;
    for (const Weights& one : weights) {
      sum += one.*sd > 0 ? one.*independent / (one.*sd * one.*sd) : 0;
    }
    return sum;
  };
  if (information(now) < information(before)) {
    for (std::size_t i = 0; i < now.size(); ++i) {
      now[i].*sd = before[i].*sd;
      now[i].*independent = before[i].*independent;
    }
  }
}

}  // namespace

/// Sets, for every comparison, the probability that an error is between martensite and austenite
/// rather than between martensite and R-phase, from the amounts of austenite and R-phase.
void Fit::apportion(std::size_t i) {
  const RunCost cost = run_cost(i);
  const std::vector<double> u = deviations(i);
  std::vector<double> austenite;
  for (const Predicted<double>& p : cost.model(cost.assumed(u.data()), cost.path(u.data()))) {
    const double a = std::max(0.0, p.phases.austenite()) + 1e-3;
    austenite.push_back(a / (a + std::max(0.0, p.phases.r_phase)));
  }
  weights_[i].austenite = std::move(austenite);
}

/// Sets each channel's standard deviation and number of independent comparisons from the residuals.
/// The weight of a channel never decreases, because the model has shown that it can be that
/// accurate. Otherwise a prior that keeps the fit away from the data would enlarge the residuals,
/// so lower the weight of the data, and keep the fit even farther away.
void Fit::weigh() {
  const std::vector<Weights> before = weights_;
  double strain2 = 0, ohm2 = 0, stress2 = 0, strains = 0, ohms = 0, stresses = 0;
  const auto length = [](const std::vector<double>& errors) {
    return static_cast<double>(errors.size()) / correlation_length(errors);
  };
  for (std::size_t i = 0; i < runs_.size(); ++i) {
    if (runs_[i].kind == RunKind::calorimetry) {
      const FittedRun run = fitted(i);
      const auto d_power = differences(run.strain_model, run.strain_measured, false);
      weights_[i].power_sd = std::max(0.005 * max_power(runs_[i]), rms(d_power));
      weights_[i].power_independent = length(d_power);
      continue;
    }
    if (runs_[i].kind == RunKind::imposed) {
      const FittedRun run = fitted(i);
      const auto d_stress = differences(run.stress_model_Pa, run.stress_measured_Pa, false);
      stress2 += std::pow(rms(d_stress), 2);
      stresses += 1;
      weights_[i].stress_independent = length(d_stress);
      continue;
    }
    apportion(i);
    const FittedRun run = fitted(i);
    const auto d_strain = differences(run.strain_model, run.strain_measured, false);
    const auto d_ohm = differences(run.resistance_given_strain, run.resistance_measured, true);
    if (!d_strain.empty()) {
      strain2 += std::pow(rms(d_strain), 2);
      strains += 1;
      weights_[i].strain_independent = length(d_strain);
    }
    if (!d_ohm.empty()) {
      ohm2 += certain_square(run, weights_[i]);
      ohms += 1;
      weights_[i].resistance_independent = length(d_ohm);
    }
  }
  for (Weights& weights : weights_) {
    weights.strain_sd = std::max(4e-5, std::sqrt(strain2 / std::max(strains, 1.0)));
    weights.resistance_sd = std::max(1e-4, std::sqrt(ohm2 / std::max(ohms, 1.0)));
    weights.stress_sd = std::max(1e5, std::sqrt(stress2 / std::max(stresses, 1.0)));
  }
  if (std::exchange(weighed_, true)) {
    keep_more(weights_, before, &Weights::strain_sd, &Weights::strain_independent);
    keep_more(weights_, before, &Weights::resistance_sd, &Weights::resistance_independent);
    keep_more(weights_, before, &Weights::power_sd, &Weights::power_independent);
    keep_more(weights_, before, &Weights::stress_sd, &Weights::stress_independent);
  }
}

/// The remaining errors now. The weights of the fit stay as they are.
Unexplained Fit::unexplained() {
  const std::vector<Weights> used = weights_;
  const bool weighed = std::exchange(weighed_, false);
  weigh();
  weighed_ = weighed;
  for (std::size_t i = 0; i < runs_.size(); ++i) {
    const bool in_time = runs_[i].kind != RunKind::calorimetry;
    weights_[i].strain_independent *= in_time && runs_[i].has_strain ? 1 : 0;
    weights_[i].resistance_independent *= in_time && runs_[i].has_resistance ? 1 : 0;
    weights_[i].stress_independent *= runs_[i].kind == RunKind::imposed ? 1 : 0;
  }
  double prior = 0;
  for (const double u : u_.wire) {
    prior += 0.5 * u * u;
  }
  return {std::exchange(weights_, used), prior};
}

double gain(const Unexplained& from, const Unexplained& to) {
  double sum = from.prior - to.prior;
  for (std::size_t i = 0; i < from.errors.size(); ++i) {
    const Weights& a = from.errors[i];
    const Weights& b = to.errors[i];
    const auto add = [&](double Weights::* sd, double Weights::* independent) {
      if (b.*sd > 0) {
        sum += std::min(a.*independent, b.*independent) * std::log(a.*sd / (b.*sd));
      }
    };
    add(&Weights::strain_sd, &Weights::strain_independent);
    add(&Weights::resistance_sd, &Weights::resistance_independent);
    add(&Weights::power_sd, &Weights::power_independent);
    add(&Weights::stress_sd, &Weights::stress_independent);
  }
  return sum;
}

FittedRun Fit::fitted(std::size_t i) {
  const RunCost cost = run_cost(i);
  const std::vector<double> u = deviations(i);
  FittedRun run{};
  run.name = runs_[i].name;
  run.kind = runs_[i].kind;
  const Assumed<double> assumed = cost.assumed<double>(u.data());
  run.circumstances = assumed.here;
  if (run.kind == RunKind::imposed) {
    run.stress_measured_Pa = runs_[i].measured_stress_Pa;
    for (const Predicted<double>& p : cost.model(assumed, cost.path(u.data()))) {
      run.stress_model_Pa.push_back(p.strain);
    }
    return run;
  }
  run.strain_measured = run.kind == RunKind::calorimetry ? runs_[i].power_W_kg : runs_[i].strain;
  run.resistance_measured = runs_[i].resistance_ohm;
  std::size_t k = 0;
  for (const Predicted<double>& p : cost.model(assumed, cost.path(u.data()))) {
    run.strain_model.push_back(p.strain);
    run.resistance_model.push_back(p.resistance_ohm);
    const double too_long = p.strain - run.strain_measured[k];
    const Exchange<double> e = exchange(weights_[i], k, p);
    const bool known = !std::isnan(too_long);
    run.resistance_given_strain.push_back(p.resistance_ohm *
                                          (known ? 1 - e.by_strain * too_long : 1));
    run.ambiguity.push_back(known ? e.ambiguity : 0);
    ++k;
  }
  for (const std::size_t step : runs_[i].after) {
    run.temperature_K.push_back(runs_[i].temperature_K.empty()
                                    ? std::numeric_limits<double>::quiet_NaN()
                                    : runs_[i].temperature_K[step]);
  }
  return run;
}

/// Computes standard deviations and correlations after the fit. Kept parameters are treated as free
/// here, so that their uncertainty contributes to the others'; their own standard deviation is that
/// of the prior.
void Fit::uncertainty(FitResult& result) {
  const Eigen::MatrixXd covariance = this->covariance(active(everything(), all));
  const std::vector<FitParameter>& parameters = problem_->parameters;
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const auto at = static_cast<Eigen::Index>(i);
    const bool determined = !kept_.contains(parameters[i].key);
    const double relative = determined ? std::min(1.0, std::sqrt(covariance(at, at))) : 1.0;
    result.parameters.push_back({parameters[i], parameters[i].value(u_.wire[i]),
                                 relative * parameters[i].sd, relative, determined});
  }
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      const auto a = static_cast<Eigen::Index>(i);
      const auto b = static_cast<Eigen::Index>(k);
      const double rho = covariance(a, b) / std::sqrt(covariance(a, a) * covariance(b, b));
      if (std::abs(rho) > 0.8 && result.parameters[i].determined &&
          result.parameters[k].determined) {
        result.correlations.push_back({parameters[k].key, parameters[i].key, rho});
      }
    }
  }
  std::ranges::sort(result.correlations, [](const Correlation& a, const Correlation& b) {
    return std::abs(a.value) > std::abs(b.value);
  });
}

/// Sets the accuracy of measured channels from the remaining errors. The others are left unchanged.
void Fit::accuracy(Accuracy<double>& of) const {
  for (std::size_t i = 0; i < runs_.size(); ++i) {
    if (runs_[i].has_strain && runs_[i].kind != RunKind::calorimetry) {
      of.strain = weights_[i].strain_sd;
      of.resistance = runs_[i].has_resistance ? weights_[i].resistance_sd : of.resistance;
    }
  }
}

/// A run with its errors from this comparison on.
FittedRun Fit::judged(std::size_t i, std::size_t first) {
  FittedRun run = fitted(i);
  const auto errors = [&](const std::vector<double>& model, const std::vector<double>& measured,
                          bool relative) {
    const auto from = [&](const std::vector<double>& all) {
      return std::vector<double>(all.begin() + static_cast<std::ptrdiff_t>(first), all.end());
    };
    return model.empty() ? std::vector<double>()
                         : differences(from(model), from(measured), relative);
  };
  if (run.kind == RunKind::imposed) {
    run.stress_Pa = quality(errors(run.stress_model_Pa, run.stress_measured_Pa, false), 1);
  } else if (run.kind == RunKind::calorimetry) {
    run.power =
        quality(errors(run.strain_model, run.strain_measured, false), 1 / max_power(runs_[i]));
  } else {
    run.strain =
        quality(errors(run.strain_model, run.strain_measured, false), 1 / from_.nominal_stroke);
    run.resistance = quality(errors(run.resistance_model, run.resistance_measured, true), 1);
    run.given_strain =
        quality(errors(run.resistance_given_strain, run.resistance_measured, true), 1);
  }
  return run;
}

void Fit::describe(FitResult& result) {
  const RunCost cost = run_cost(0);
  const std::vector<double> u = deviations(0);
  const Assumed<double> assumed = cost.assumed<double>(u.data());
  result.wire = restored(assumed.wire);
  accuracy(result.wire.accuracy);
  result.strain_sd = result.wire.accuracy.strain;
  const Honest honest = honest_strain_sd(result.strain_sd);
  result.wire.accuracy.strain = honest.strain_sd;
  result.share_within_2_sd = honest.share_within_2_sd;
  result.structure_asked = options_.structure;
  result.judgement = judgement_;
  result.circuit = assumed.circuit;
  result.circuit_fitted = problem_->variant.circuit;
  result.variant = problem_->variant;
  for (std::size_t i = 0; i < runs_.size(); ++i) {
    result.runs.push_back(judged(i, 0));
  }
  result.interrupted = interrupted_;
  result.converged = converged_ || interrupted_;
  result.iterations = iterations_;
}

}  // namespace smaservo::identify
