#pragma once
// The residuals of commissioning as a function of the wire's deviations from the type.

#include <Eigen/Core>
#include <ceres/cost_function.h>
#include <cstddef>
#include <functional>
#include <vector>

#include "host-sim/commission/anchor.hpp"
#include "host-sim/commission/passage.hpp"
#include "host-sim/identify/fit/parameters.hpp"

namespace smaservo::commission {

/// A wire to begin from, and those of its parameters that a run without a strain may change. Their
/// prior deviations are those between pieces of a type.
class Beginning {
 public:
  explicit Beginning(const Wire<double>& wire);

  const std::vector<identify::FitParameter>& parameters() const { return parameters_; }
  /// For these deviations, of which there is one for each of the parameters.
  Wire<double> wire(const double* u) const;

 private:
  Wire<double> from_;
  identify::FitVariant variant_;
  std::vector<identify::FitParameter> parameters_;
};

/// What the readings of a run are, and where their zero is.
struct PlacedAnchors {
  const std::vector<Anchor>& anchors;
  /// Standard deviation of the strain at displacement 0 around 0; 0: it may be anywhere.
  double zero_sd;
  double length_m;  ///< of the wire: contraction per strain
};

/// Its deviations are those of Beginning and, where there are readings, one of their zero.
class EndToEndCost final : public ceres::CostFunction {
 public:
  /// `ambient_sd_K` is that of the air's temperature at the start.
  EndToEndCost(const Beginning& beginning, const ObservedWire& seen, const PlacedAnchors& readings,
               double ambient_sd_K, int threads);

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

  std::size_t size() const { return beginning_.parameters().size() + (has_zero() ? 1 : 0); }
  Passage passage(const double* u) const { return pass(seen_, beginning_.wire(u)); }
  /// The strain at displacement 0.
  double zero(const double* u) const;

  /// Derivatives of the residuals and of Passage::strain by the deviations around `u`.
  struct Linear {
    Eigen::MatrixXd residuals, strain;
  };
  Linear linear(const double* u) const;

  /// Of anchor i, in standard deviations.
  double anchor_residual(std::size_t i, const Passage& passage, const double* u) const;

 private:
  bool has_zero() const { return !readings_.anchors.empty(); }
  Eigen::VectorXd residuals(const Passage& passage, const double* u) const;

  const Beginning& beginning_;
  const ObservedWire& seen_;
  PlacedAnchors readings_;
  double first_zero_ = 0;
  double ambient_sd_K_;
  int threads_;
};

}  // namespace smaservo::commission
