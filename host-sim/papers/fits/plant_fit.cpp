#include "host-sim/papers/fits/plant_fit.hpp"

#include <algorithm>
#include <ceres/ceres.h>
#include <cmath>
#include <limits>
#include <memory>

#include "host-sim/identify/fit/cost/run_cost.hpp"
#include "host-sim/parallel.hpp"

namespace smaservo::fits {
namespace {

constexpr double strain_sd = 5e-4;
double weight(const DrivenSteps& run) {
  const auto rows = std::ranges::count_if(run.strain, [](double x) { return !std::isnan(x); });
  return identify::share_of(identify::independent_at_first, static_cast<std::size_t>(rows));
}

/// The residuals of all runs and of the prior, as functions of all deviations, in one block, so
/// that the sums do not depend on the number of threads.
class StrainResiduals final : public ceres::CostFunction {
 public:
  StrainResiduals(std::size_t count, const std::vector<DrivenSteps>& runs,
                  const StrainOf& strain_of, int threads)
      : count_(count),
        runs_(runs),
        strain_of_(strain_of),
        threads_(std::min(threads, static_cast<int>(runs.size()))) {
    for (const DrivenSteps& run : runs) {
      first_row_.push_back(prior_row_);
      prior_row_ += run.strain.size();
    }
    mutable_parameter_block_sizes()->push_back(static_cast<int>(count));
    set_num_residuals(static_cast<int>(prior_row_ + count));
  }

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    const std::vector<double> u(parameters[0], parameters[0] + count_);
    double* jacobian = jacobians == nullptr ? nullptr : jacobians[0];
    parallel(
        runs_.size(), threads_,
        [&](std::size_t run) {
          evaluate(run, u, residuals + first_row_[run]);
          if (jacobian != nullptr) {
            differentiate(run, u, jacobian + first_row_[run] * count_);
          }
        },
        [](std::size_t) {});
    for (std::size_t k = 0; k < count_; ++k) {
      residuals[prior_row_ + k] = u[k];
      if (jacobian != nullptr) {
        double* row = jacobian + (prior_row_ + k) * count_;
        std::fill_n(row, count_, 0.0);
        row[k] = 1;
      }
    }
    return true;
  }

 private:
  void evaluate(std::size_t run, const std::vector<double>& u, double* residuals) const {
    const std::vector<double>& measured = runs_[run].strain;
    const std::vector<double> strain = strain_of_(u, runs_[run]);
    const double share = weight(runs_[run]);
    for (std::size_t i = 0; i < strain.size(); ++i) {
      const double error = (strain[i] - measured[i]) / strain_sd;
      residuals[i] = std::isnan(error) ? 0 : share * identify::robust(error);
    }
  }

  void differentiate(std::size_t run, std::vector<double> u, double* jacobian) const {
    // A step of a hundredth of a prior's deviation to both sides is wider than the kinks that
    // turning points cause in the cost.
    constexpr double step = 1e-2;
    const std::size_t rows = runs_[run].strain.size();
    std::vector<double> above(rows), below(rows);
    for (std::size_t k = 0; k < count_; ++k) {
      const double here = u[k];
      u[k] = here + step;
      evaluate(run, u, above.data());
      u[k] = here - step;
      evaluate(run, u, below.data());
      u[k] = here;
      for (std::size_t i = 0; i < rows; ++i) {
        jacobian[i * count_ + k] = (above[i] - below[i]) / (2 * step);
      }
    }
  }

  std::size_t count_;
  const std::vector<DrivenSteps>& runs_;
  const StrainOf& strain_of_;
  int threads_;
  std::vector<std::size_t> first_row_;
  std::size_t prior_row_ = 0;
};

}  // namespace

std::vector<double> fit_deviations(std::size_t count, const std::vector<DrivenSteps>& runs,
                                   const StrainOf& strain_of,
                                   const std::vector<std::vector<double>>& starts, int threads) {
  std::vector<double> u(count, 0.0);
  ceres::Problem problem;
  problem.AddResidualBlock(
      std::make_unique<StrainResiduals>(count, runs, strain_of, threads).release(), nullptr,
      u.data());
  for (int i = 0; i < static_cast<int>(count); ++i) {
    problem.SetParameterLowerBound(u.data(), i, -5);
    problem.SetParameterUpperBound(u.data(), i, 5);
  }
  std::vector<double> best = u;
  double min = std::numeric_limits<double>::infinity();
  for (const std::vector<double>& start : starts) {
    u = start;
    double cost = 0;
    problem.Evaluate({}, &cost, nullptr, nullptr, nullptr);
    if (cost < min) {
      min = cost;
      best = u;
    }
  }
  u = best;
  ceres::Solver::Options solver;
  solver.linear_solver_type = ceres::DENSE_NORMAL_CHOLESKY;
  solver.function_tolerance = 1e-4;
  solver.max_num_iterations = 40;
  solver.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &problem, &summary);
  return u;
}

}  // namespace smaservo::fits
