#include "host-sim/compare/plant_fit.hpp"

#include <algorithm>
#include <ceres/ceres.h>
#include <ceres/normal_prior.h>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <memory>
#include <numeric>

#include "host-sim/identify/fit.hpp"
#include "host-sim/identify/run_cost.hpp"
#include "host-sim/output_file.hpp"
#include "observer/kalman.hpp"

namespace smaservo {
namespace {

constexpr double strain_sd = 5e-4;
/// A load cell's noise would walk models without memory to the middle of their loops. As the
/// observer has it.
constexpr double load_filter_s = KalmanTuning<double>{}.stress_filter_s;
constexpr double nothing = std::numeric_limits<double>::quiet_NaN();

double ambient_of(const Run& run, double otherwise_K) {
  return run.ambient_K.empty() ? otherwise_K
                               : std::accumulate(run.ambient_K.begin(), run.ambient_K.end(), 0.0) /
                                     static_cast<double>(run.ambient_K.size());
}

void require_motion(const Run& run) {
  if (run.kind != RunKind::joule && run.kind != RunKind::bath) {
    throw UserError(fmt::format("{}: is a {} run; must be of Joule heating or of a bath", run.name,
                                name_of(run.kind)));
  }
}

double weight(const DrivenSteps& run) {
  const auto rows = std::ranges::count_if(run.strain, [](double x) { return !std::isnan(x); });
  return share_of(independent_at_first, static_cast<std::size_t>(rows));
}

/// One run's residuals by all deviations.
class StrainResiduals final : public ceres::CostFunction {
 public:
  StrainResiduals(int count, const DrivenSteps& run, const StrainOf& strain_of)
      : run_(run), strain_of_(strain_of), weight_(weight(run)) {
    mutable_parameter_block_sizes()->push_back(count);
    set_num_residuals(static_cast<int>(run.strain.size()));
  }

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    const auto count = static_cast<std::size_t>(parameter_block_sizes()[0]);
    std::vector<double> u(parameters[0], parameters[0] + count);
    evaluate(u, residuals);
    if (jacobians == nullptr || jacobians[0] == nullptr) {
      return true;
    }
    // A hundredth of a prior's deviation to both sides: wider than the kinks that turning points
    // leave in the cost.
    constexpr double step = 1e-2;
    const std::size_t rows = run_.strain.size();
    std::vector<double> above(rows), below(rows);
    for (std::size_t k = 0; k < count; ++k) {
      const double here = u[k];
      u[k] = here + step;
      evaluate(u, above.data());
      u[k] = here - step;
      evaluate(u, below.data());
      u[k] = here;
      for (std::size_t i = 0; i < rows; ++i) {
        jacobians[0][i * count + k] = (above[i] - below[i]) / (2 * step);
      }
    }
    return true;
  }

 private:
  void evaluate(const std::vector<double>& u, double* residuals) const {
    const std::vector<double> strain = strain_of_(u, run_);
    for (std::size_t i = 0; i < strain.size(); ++i) {
      const double error = (strain[i] - run_.strain[i]) / strain_sd;
      residuals[i] = std::isnan(error) ? 0 : weight_ * robust(error);
    }
  }

  const DrivenSteps& run_;
  const StrainOf& strain_of_;
  double weight_;
};

}  // namespace

DrivenSteps every_row(const Run& run, double ambient_K) {
  require_motion(run);
  DrivenSteps steps{
      run.kind == RunKind::bath, ambient_of(run, ambient_K), {}, {}, {}, run.stress_Pa, run.strain};
  if (steps.bath) {
    steps.temperature_K = run.temperature_K;
    return steps;
  }
  const std::size_t rows = run.time_s.size();
  for (std::size_t i = 0; i < rows; ++i) {
    const std::size_t before = i == 0 ? 0 : i - 1;
    steps.dt_s.push_back(i == 0 ? run.time_s[1] - run.time_s[0]
                                : run.time_s[i] - run.time_s[before]);
    steps.power_W.push_back(0.5 * (run.current_A[i] * run.voltage_V[i] +
                                   run.current_A[before] * run.voltage_V[before]));
    const double weight = steps.dt_s[i] / (steps.dt_s[i] + load_filter_s);
    steps.stress_Pa[i] =
        steps.stress_Pa[before] + weight * (run.stress_Pa[i] - steps.stress_Pa[before]);
  }
  return steps;
}

DrivenSteps thinned(const Run& run) {
  require_motion(run);
  const FitRun fit = thin_run(run, coarse_step_s);
  DrivenSteps steps{run.kind == RunKind::bath, ambient_of(run, room_K), fit.dt_s, fit.power_W,
                    fit.temperature_K,         fit.stress_Pa,           {}};
  steps.strain.assign(fit.stress_Pa.size(), nothing);
  for (std::size_t i = 0; i < fit.after.size(); ++i) {
    steps.strain[fit.after[i]] = fit.strain[i];
  }
  return steps;
}

std::vector<double> fit_deviations(std::size_t count, const std::vector<DrivenSteps>& runs,
                                   const StrainOf& strain_of,
                                   const std::vector<std::vector<double>>& starts, int threads) {
  const auto size = static_cast<int>(count);
  std::vector<double> u(count, 0.0);
  ceres::Problem problem;
  for (const DrivenSteps& run : runs) {
    problem.AddResidualBlock(std::make_unique<StrainResiduals>(size, run, strain_of).release(),
                             nullptr, u.data());
  }
  const ceres::Vector none = ceres::Vector::Zero(size);
  problem.AddResidualBlock(
      std::make_unique<ceres::NormalPrior>(ceres::Matrix::Identity(size, size), none).release(),
      nullptr, u.data());
  for (int i = 0; i < size; ++i) {
    problem.SetParameterLowerBound(u.data(), i, -5);
    problem.SetParameterUpperBound(u.data(), i, 5);
  }
  std::vector<double> best = u;
  double least = std::numeric_limits<double>::infinity();
  for (const std::vector<double>& start : starts) {
    u = start;
    double cost = 0;
    problem.Evaluate({}, &cost, nullptr, nullptr, nullptr);
    if (cost < least) {
      least = cost;
      best = u;
    }
  }
  u = best;
  ceres::Solver::Options solver;
  solver.linear_solver_type = ceres::DENSE_NORMAL_CHOLESKY;
  solver.function_tolerance = 1e-4;
  solver.max_num_iterations = 40;
  solver.num_threads = threads;
  solver.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &problem, &summary);
  return u;
}

}  // namespace smaservo
