#pragma once
// The residuals of all runs, and the prior, by the deviations that a stage of the fit may change:
// one block of parameters for Ceres. The runs are evaluated side by side; the result does not
// depend on the number of threads.

#include <ceres/cost_function.h>
#include <cstddef>
#include <optional>
#include <vector>

#include "host-sim/identify/fit/cost/run_cost.hpp"

namespace smaservo::identify {

/// One deviation that may change.
struct Active {
  double* value;
  std::size_t index;               ///< among those that a RunCost depends on
  std::optional<std::size_t> run;  ///< of one run only
};

/// Where they are now.
std::vector<double> values(const std::vector<Active>& active);

class AllRunsCost final : public ceres::CostFunction {
 public:
  struct One {
    RunCost cost;
    std::vector<double> fixed;  ///< all of its deviations; those that are active are replaced
    std::size_t run;
  };

  AllRunsCost(std::vector<One> runs, const std::vector<Active>& active, int threads);

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  /// Which active deviation is which of a run's.
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
