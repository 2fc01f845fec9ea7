#include "host-sim/identify/classic.hpp"

#include <algorithm>
#include <array>
#include <ceres/autodiff_cost_function.h>
#include <ceres/problem.h>
#include <ceres/solver.h>
#include <cmath>
#include <limits>
#include <numbers>

#include "host-sim/identify/steady_load.hpp"

namespace smaservo {
namespace {

enum class Shape : unsigned char { cosine, tanh, arctan };

/// The martensite fraction at `u` widths above the centre. The cosine's width is from start to
/// finish; one width beside the centre, tanh has 12 % left to convert and arctan 25 %.
template <class S>
S fraction(Shape shape, const S& u) {
  using std::atan;
  using std::cos;
  using std::tanh;
  constexpr double pi = std::numbers::pi;
  switch (shape) {
    case Shape::cosine:
      if (u <= S(-0.5)) return S(1);
      if (u >= S(0.5)) return S(0);
      return S(0.5) * (S(1) + cos(pi * (u + S(0.5))));
    case Shape::tanh:
      return S(0.5) * (S(1) - tanh(u));
    case Shape::arctan:
      return S(0.5) - atan(u) / pi;
  }
  return S(0);
}

/// Of the parameters that all shapes have; cooling's centre and width stand behind heating's.
enum Index : int { martensite, austenite, centre, width };
constexpr int cooling = 2;
constexpr int parameter_count = 6;
using Parameters = std::array<double, parameter_count>;

template <class S>
S strain_at(Shape shape, const S* p, double temperature_K, bool cools) {
  const S* branch = p + (cools ? cooling : 0);
  const S xi = fraction(shape, (S(temperature_K) - branch[centre]) / branch[width]);
  return p[austenite] + (p[martensite] - p[austenite]) * xi;
}

struct Residual {
  Shape shape;
  double temperature_K, strain, stroke;
  bool cools;

  template <class S>
  bool operator()(const S* p, S* residual) const {
    residual[0] = (strain_at(shape, p, temperature_K, cools) - S(strain)) / S(stroke);
    return true;
  }
};

/// One heating and one cooling, split at the hottest row.
struct Cycle {
  const std::vector<double>& temperature_K;
  const std::vector<double>& strain;
  std::size_t hottest;
  double shortest, stroke;
};

/// Whether the wire is cold and long at both ends, and the temperature has one summit.
bool is_one_cycle(const Cycle& cycle) {
  const std::vector<double>& T = cycle.temperature_K;
  const double coldest_K = *std::ranges::min_element(T);
  const double span_K = T[cycle.hottest] - coldest_K;
  const double long_strain = cycle.shortest + 0.75 * cycle.stroke;
  for (const std::size_t end : {std::size_t{0}, T.size() - 1}) {
    if (T[end] > coldest_K + 0.25 * span_K || cycle.strain[end] < long_strain) {
      return false;
    }
  }
  if (cycle.strain[cycle.hottest] > cycle.shortest + 0.25 * cycle.stroke) {
    return false;
  }
  const double most_back_K = 0.1 * span_K;
  double before_K = coldest_K;
  for (std::size_t i = 0; i <= cycle.hottest; ++i) {
    before_K = std::max(before_K, T[i]);
    if (T[i] < before_K - most_back_K) return false;
  }
  double after_K = T[cycle.hottest];
  for (std::size_t i = cycle.hottest; i < T.size(); ++i) {
    after_K = std::min(after_K, T[i]);
    if (T[i] > after_K + most_back_K) return false;
  }
  return true;
}

/// Where a branch has half of the stroke behind it.
double start_K(const Cycle& cycle, std::size_t from, std::size_t to) {
  const double half = cycle.shortest + 0.5 * cycle.stroke;
  std::size_t nearest = from;
  for (std::size_t i = from; i < to; ++i) {
    if (std::abs(cycle.strain[i] - half) < std::abs(cycle.strain[nearest] - half)) {
      nearest = i;
    }
  }
  return cycle.temperature_K[nearest];
}

Parameters best_parameters(Shape shape, const Cycle& cycle) {
  constexpr std::size_t most_rows = 2000;
  const std::size_t rows = cycle.strain.size();
  const std::size_t stride = 1 + (rows - 1) / most_rows;
  Parameters best{};
  double least_cost = std::numeric_limits<double>::infinity();
  for (const double start_width_K : {2.0, 6.0, 18.0, 40.0}) {
    Parameters p{cycle.shortest + cycle.stroke,        cycle.shortest,
                 start_K(cycle, 0, cycle.hottest + 1), start_width_K,
                 start_K(cycle, cycle.hottest, rows),  start_width_K};
    ceres::Problem problem;
    for (std::size_t i = 0; i < rows; i += stride) {
      problem.AddResidualBlock(
          new ceres::AutoDiffCostFunction<Residual, 1, parameter_count>(new Residual{
              shape, cycle.temperature_K[i], cycle.strain[i], cycle.stroke, i > cycle.hottest}),
          nullptr, p.data());
    }
    constexpr double least_width_K = 0.01;
    problem.SetParameterLowerBound(p.data(), width, least_width_K);
    problem.SetParameterLowerBound(p.data(), cooling + width, least_width_K);
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::DENSE_NORMAL_CHOLESKY;
    options.max_num_iterations = 200;
    options.function_tolerance = 1e-12;
    options.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
    if (summary.IsSolutionUsable() && summary.final_cost < least_cost) {
      least_cost = summary.final_cost;
      best = p;
    }
  }
  return best;
}

ClassicFit fitted(Shape shape, std::string_view name, const Cycle& cycle) {
  const Parameters p = best_parameters(shape, cycle);
  ClassicFit fit{name,
                 0,
                 0,
                 0,
                 {},
                 p[martensite],
                 p[austenite],
                 p[centre],
                 p[width],
                 p[cooling + centre],
                 p[cooling + width]};
  std::vector<double> errors;
  double squares = 0;
  for (std::size_t i = 0; i < cycle.strain.size(); ++i) {
    fit.strain.push_back(strain_at(shape, p.data(), cycle.temperature_K[i], i > cycle.hottest));
    errors.push_back(std::abs(fit.strain.back() - cycle.strain[i]) / cycle.stroke);
    squares += errors.back() * errors.back();
  }
  fit.rms = std::sqrt(squares / static_cast<double>(errors.size()));
  fit.p95 = quantile(errors, 0.95);
  fit.max = quantile(errors, 1);
  return fit;
}

}  // namespace

std::vector<ClassicFit> fit_classics(const Run& run) {
  if (run.kind != RunKind::bath || run.strain.empty() || !has_constant_stress(run)) {
    return {};
  }
  const auto hottest = std::ranges::max_element(run.temperature_K) - run.temperature_K.begin();
  const auto [shortest, longest] = std::ranges::minmax(run.strain);
  const Cycle cycle{run.temperature_K, run.strain, static_cast<std::size_t>(hottest), shortest,
                    longest - shortest};
  if (!(cycle.stroke > 0) || !is_one_cycle(cycle)) {
    return {};
  }
  return {fitted(Shape::cosine, "cosine", cycle), fitted(Shape::tanh, "tanh", cycle),
          fitted(Shape::arctan, "arctan", cycle)};
}

}  // namespace smaservo
