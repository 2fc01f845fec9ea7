#pragma once
// The residuals of all runs, of the prior, and of the law that no transition temperature falls with
// stress. They are functions of the deviations that a stage of the fit may change, which are one
// block of parameters for Ceres. The runs are evaluated in parallel; the result does not depend on
// the number of threads.

#include <Eigen/Core>
#include <ceres/cost_function.h>
#include <cstddef>
#include <optional>
#include <vector>

#include "host-sim/identify/fit/cost/rise_cost.hpp"
#include "host-sim/identify/fit/cost/run_cost.hpp"

namespace smaservo::identify {

/// One deviation that may change.
struct Active {
  double* value;
  std::size_t index;               ///< index of the deviation among those that a RunCost depends on
  std::optional<std::size_t> run;  ///< the only run that it belongs to; none: all runs
};

/// The present values of these deviations.
std::vector<double> values(const std::vector<Active>& active);

class AllRunsCost final : public ceres::CostFunction {
 public:
  struct One {
    RunCost cost;
    std::vector<double> fixed;  ///< all deviations of the run; active ones are replaced
    std::size_t run;
  };

  AllRunsCost(std::vector<One> runs, const RiseCost& rise, const std::vector<Active>& active,
              int threads);

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

  /// The information of the runs and the prior on the active deviations around `x`, without the law
  /// that no transition falls: JᵀJ, whose inverse is their covariance.
  Eigen::MatrixXd information(const std::vector<double>& x) const;

 private:
  /// An active deviation: its column in the Jacobian, and its index among the run's deviations.
  struct Column {
    std::size_t column, index;
  };
  std::vector<Column> columns(std::optional<std::size_t> run) const;
  std::size_t rise_row() const { return prior_row_ + active_.size(); }
  /// Computes the residuals of one of the costs that depend on the wire.
  template <class Cost>
  void evaluate(const Cost& cost, const std::vector<Column>& columns, std::vector<double> u,
                const double* x, double* residuals, double* jacobian) const;

  std::vector<One> runs_;
  RiseCost rise_;
  std::vector<std::size_t> first_row_;
  std::vector<Active> active_;
  std::size_t prior_row_ = 0;
  std::size_t threads_;
};

}  // namespace smaservo::identify
