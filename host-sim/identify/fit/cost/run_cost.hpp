#pragma once
// The residuals of the fit for one run: how well a wire explains it. Used only inside the fit.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include "host-sim/identify/fit/cost/prediction.hpp"
#include "host-sim/identify/fit/parameters.hpp"

namespace smaservo::identify {

/// Residuals beyond this many standard deviations have a reduced weight: soft L1.
inline constexpr double robust_sd = 3;
/// Errors of neighbouring comparisons are correlated. Until the fit has shown how far, each channel
/// of a run counts as this many independent comparisons.
inline constexpr double independent_at_first = 150;

template <class T>
T robust(const T& r) {
  using std::sqrt;
  const T s = r * r / T(robust_sd * robust_sd);
  // ρ(r²) = 2 δ² (sqrt(1 + r²/δ²) - 1), as the square of a residual
  return r * sqrt(T(2) / (T(1) + sqrt(T(1) + s)));
}

/// The weights of a run's channels.
struct Weights {
  double strain_sd = 2e-4;
  double resistance_sd = 2e-3;  ///< relative
  double power_sd = 0;          ///< W/kg
  double power_independent = independent_at_first;
  double stress_sd = 0;  ///< Pa
  double stress_independent = independent_at_first;
  double strain_independent = independent_at_first;
  double resistance_independent = independent_at_first;
  /// For every comparison, the probability that an error of the strain comes from austenite in
  /// place of martensite; otherwise it comes from R-phase. Empty at first: strain and resistance
  /// are then compared independently.
  std::vector<double> austenite;
};

/// An error of the strain causes an error of the resistance as well. This part is subtracted from
/// the resistance's error, so that the comparison shows whether the resistance fits the measured
/// strain. That is what an observer needs, and it is far more accurate.
template <class T>
struct Exchange {
  T by_strain;       ///< relative change of the resistance for the error of the strain
  double ambiguity;  ///< its standard deviation, since the phase that causes it is not known
};
template <class T>
Exchange<T> exchange(const Weights& weights, std::size_t i, const Predicted<T>& p) {
  if (weights.austenite.empty()) {
    return {T(0), 0};
  }
  const double share = weights.austenite[i];
  return {T(share) * p.for_austenite + T(1 - share) * p.for_r_phase,
          std::sqrt(share * (1 - share)) * std::abs(number_of(p.for_austenite - p.for_r_phase))};
}

inline double share_of(double independent, std::size_t count) {
  return count == 0 ? 0 : std::sqrt(std::min(1.0, independent / static_cast<double>(count)));
}

inline std::size_t valid(const std::vector<double>& column) {
  return static_cast<std::size_t>(
      std::ranges::count_if(column, [](double x) { return !std::isnan(x); }));
}

enum CircumstanceIndex { iAmbient, iLoss, iZero, iGain, iRate, iPowerZero, circumstance_count };
enum CircuitIndex { iLead, iLoad, circuit_count };

/// The part of the problem that is common to all runs of a fit.
struct FitProblem {
  const Wire<double>& from;
  FitVariant variant;
  std::vector<FitParameter> parameters;
  std::array<FitParameter, circuit_count> circuit_parameters;
};

/// The parameters that belong to one run.
using CircumstanceParameters = std::array<FitParameter, circumstance_count>;

/// The residuals of one run as a function of the deviations `u`: those of the wire, of the circuit
/// and of the run.
class RunCost {
 public:
  RunCost(const FitProblem& problem, const FitRun& run, const CircumstanceParameters& circumstances,
          const Weights& weights)
      : problem_(problem), run_(run), circumstances_(circumstances), weights_(weights) {}

  /// The path of the wire at `u`, which is the same for all derivatives.
  Path path(const double* u) const { return path_of(run_, assumed(u)); }

  template <class T>
  void operator()(const T* u, const Path& path, T* residual) const {
    const std::vector<Predicted<T>> predicted = model(assumed(u), path);
    const std::size_t n = run_.after.size();
    const auto term = [](const T& error, double sd, double share) {
      return robust(error / T(sd)) * T(share);
    };
    if (run_.kind == RunKind::calorimetry) {
      const double share = share_of(weights_.power_independent, valid(run_.power_W_kg));
      for (std::size_t i = 0; i < n; ++i) {
        const double measured = run_.power_W_kg[i];
        residual[i] = std::isnan(measured)
                          ? T(0)
                          : term(predicted[i].strain - T(measured), weights_.power_sd, share);
      }
      return;
    }
    if (run_.kind == RunKind::imposed) {
      const double share = share_of(weights_.stress_independent, n);
      for (std::size_t i = 0; i < n; ++i) {
        residual[i] =
            term(predicted[i].strain - T(run_.measured_stress_Pa[i]), weights_.stress_sd, share);
      }
      return;
    }
    const double strain_share = share_of(weights_.strain_independent, valid(run_.strain));
    const double ohm_share = share_of(weights_.resistance_independent, valid(run_.resistance_ohm));
    for (std::size_t i = 0; i < n; ++i) {
      const Predicted<T>& p = predicted[i];
      const bool has_strain = !std::isnan(run_.strain[i]);
      const T too_long = has_strain ? T(p.strain - T(run_.strain[i])) : T(0);
      residual[2 * i] = term(too_long, weights_.strain_sd, strain_share);
      const double measured = run_.resistance_ohm[i];
      if (std::isnan(measured)) {
        residual[2 * i + 1] = T(0);
        continue;
      }
      const Exchange<T> e = exchange(weights_, i, p);
      const T rest = (p.resistance_ohm - T(measured)) / T(measured) - e.by_strain * too_long;
      const double ambiguous = has_strain ? e.ambiguity * weights_.strain_sd : 0;
      residual[2 * i + 1] = term(rest, std::hypot(weights_.resistance_sd, ambiguous), ohm_share);
    }
  }

  template <class T>
  Assumed<T> assumed(const T* u) const {
    std::size_t i = 0;
    const auto next = [&](const FitParameter& parameter) { return parameter.value(u[i++]); };
    Assumed<T> all;
    all.wire = vary_wire<T>(problem_.from, problem_.variant, next);
    all.circuit.lead_ohm = next(problem_.circuit_parameters[iLead]);
    all.circuit.load_gain = next(problem_.circuit_parameters[iLoad]);
    all.here.ambient_K = next(circumstances_[iAmbient]);
    all.here.loss = next(circumstances_[iLoss]);
    all.here.strain_zero = next(circumstances_[iZero]);
    all.here.resistance_gain = next(circumstances_[iGain]);
    all.here.rate_K_s = next(circumstances_[iRate]);
    all.here.power_zero_W_kg = next(circumstances_[iPowerZero]);
    return all;
  }

  /// `all` are the assumptions of the fit at the deviations that `path` belongs to.
  template <class T>
  std::vector<Predicted<T>> model(const Assumed<T>& all, const Path& path) const {
    std::vector<Predicted<T>> predicted;
    predict(run_, all, path, predicted);
    return predicted;
  }

  std::size_t residuals() const {
    const bool one = run_.kind == RunKind::calorimetry || run_.kind == RunKind::imposed;
    return one ? run_.after.size() : 2 * run_.after.size();
  }
  /// Number of deviations that it depends on: those of the wire, of the circuit and of the run.
  std::size_t size() const {
    return problem_.parameters.size() + circuit_count + circumstance_count;
  }

 private:
  const FitProblem& problem_;
  const FitRun& run_;
  const CircumstanceParameters& circumstances_;
  const Weights& weights_;
};

}  // namespace smaservo::identify
