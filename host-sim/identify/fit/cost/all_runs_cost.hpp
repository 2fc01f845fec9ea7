#pragma once
// The residuals of all runs and of the prior as functions of the deviations that a stage of the fit
// may change, which are one block of parameters for Ceres. The runs are evaluated side by side; the
// result does not depend on the number of threads.

#include <ceres/cost_function.h>
#include <cstddef>
#include <optional>
#include <vector>

#include "host-sim/identify/fit/cost/run_cost.hpp"

namespace smaservo::identify {

/// One deviation that may change.
struct Active {
  double* value;
  std::size_t index;               ///< of the deviation among those that a RunCost depends on
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

  AllRunsCost(std::vector<One> runs, const std::vector<Active>& active, int threads);

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  /// An active deviation: its column in the Jacobian, its index among the run's deviations.
  struct Column {
    std::size_t column, index;
  };
  std::vector<Column> columns(std::size_t run) const;
  void evaluate(std::size_t i, const double* x, double* residuals, double* jacobian) const;

  std::vector<One> runs_;
  std::vector<std::size_t> first_row_;
  std::vector<Active> active_;
  std::size_t prior_row_ = 0;
  std::size_t threads_;
};

}  // namespace smaservo::identify
