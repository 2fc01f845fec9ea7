#include "host-sim/identify/classic.hpp"

#include <algorithm>
#include <array>
#include <ceres/autodiff_cost_function.h>
#include <ceres/problem.h>
#include <ceres/solver.h>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "host-sim/identify/runs/steady_load.hpp"
#include "model/wire/three_phase/ihyp.hpp"

namespace smaservo::identify {
namespace {

enum class Shape : unsigned char { cosine, tanh, arctan, bezier, ihyp };

/// Indices of the parameters that all shapes have; those of the cooling branch follow.
enum Index : int { martensite, austenite, centre, width, form };
constexpr int plateaus = 2;

constexpr std::size_t form_count(Shape shape) {
  return shape == Shape::bezier ? 4 : shape == Shape::ihyp ? 2 : 0;
}
/// Offset from the index of a heating branch's parameter to that of the cooling branch.
constexpr int cooling(Shape shape) {
  return 2 + static_cast<int>(form_count(shape));
}
constexpr int shape_parameters(Shape shape) {
  return plateaus + 2 * cooling(shape);
}

/// The martensite fraction at `u` widths above the centre. The widths of cosine, Bezier and ihyp
/// extend from start to finish; one width above the centre, tanh has 12 % left to convert and
/// arctan 25 %.
template <Shape shape, class S>
S fraction(const S* own, const S& u) {
  using std::atan;
  using std::cos;
  using std::tanh;
  constexpr double pi = std::numbers::pi;
  if constexpr (shape == Shape::cosine) {
    if (u <= S(-0.5)) {
      return S(1);
    }
    if (u >= S(0.5)) {
      return S(0);
    }
    return S(0.5) * (S(1) + cos(pi * (u + S(0.5))));
  } else if constexpr (shape == Shape::tanh) {
    return S(0.5) * (S(1) - tanh(u));
  } else if constexpr (shape == Shape::arctan) {
    return S(0.5) - atan(u) / pi;
  } else if constexpr (shape == Shape::bezier) {
    return bezier_fraction(BezierShape<S>{own[0], own[1], own[2], own[3]}, u + S(0.5));
  } else {
    return ihyp_fraction(IhypShape<S>{own[0], own[1]}, u + S(0.5)).remaining;
  }
}

template <Shape shape, class S>
S strain_at(const S* p, double temperature_K, bool cools) {
  const S* branch = p + (cools ? cooling(shape) : 0);
  const S xi = fraction<shape>(branch + form, (S(temperature_K) - branch[centre]) / branch[width]);
  return p[austenite] + (p[martensite] - p[austenite]) * xi;
}

template <Shape shape>
struct Residual {
  double temperature_K, strain, stroke;
  bool cools;

  template <class S>
  bool operator()(const S* p, S* residual) const {
    residual[0] = (strain_at<shape>(p, temperature_K, cools) - S(strain)) / S(stroke);
    return true;
  }
};

/// One heating and one cooling, split at the hottest row.
struct Cycle {
  std::vector<double> temperature_K, strain;
  /// So many rows of the run's beginning, which cooled from hot to cold, stand at the end here.
  std::size_t turned;
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
  const double max_back_K = 0.1 * span_K;
  double before_K = coldest_K;
  for (std::size_t i = 0; i <= cycle.hottest; ++i) {
    before_K = std::max(before_K, T[i]);
    if (T[i] < before_K - max_back_K) {
      return false;
    }
  }
  double after_K = T[cycle.hottest];
  for (std::size_t i = cycle.hottest; i < T.size(); ++i) {
    after_K = std::min(after_K, T[i]);
    if (T[i] > after_K + max_back_K) {
      return false;
    }
  }
  return true;
}

/// The temperature at which a branch has covered half of the stroke.
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

/// Start and bounds of the form parameter of a shape.
struct FormLimits {
  double start, min, max;
};
template <Shape shape>
constexpr std::array<FormLimits, form_count(shape)> form_limits() {
  if constexpr (shape == Shape::bezier) {
    constexpr double third = 1.0 / 3;
    return {{{third, 0.02, 0.98}, {2 * third, 0.02, 0.98}, {1 - third, 0, 1}, {third, 0, 1}}};
  } else if constexpr (shape == Shape::ihyp) {
    return {{{1, 1e-3, 30}, {0.5, 0.05, 0.95}}};
  } else {
    return {};
  }
}

template <Shape shape>
using Parameters = std::array<double, static_cast<std::size_t>(shape_parameters(shape))>;

template <Shape shape>
Parameters<shape> start_parameters(const Cycle& cycle, double start_width_K) {
  Parameters<shape> p{};
  p[martensite] = cycle.shortest + cycle.stroke;
  p[austenite] = cycle.shortest;
  const double centres_K[] = {start_K(cycle, 0, cycle.hottest + 1),
                              start_K(cycle, cycle.hottest, cycle.strain.size())};
  double* branch = p.data();
  for (const double centre_K : centres_K) {
    branch[centre] = centre_K;
    branch[width] = start_width_K;
    for (std::size_t own = form; const FormLimits& limits : form_limits<shape>()) {
      branch[own++] = limits.start;
    }
    branch += cooling(shape);
  }
  return p;
}

template <Shape shape>
void bound(ceres::Problem& problem, double* p) {
  constexpr double min_width_K = 0.01;
  for (const int branch : {0, cooling(shape)}) {
    problem.SetParameterLowerBound(p, branch + width, min_width_K);
    for (int own = branch + form; const FormLimits& limits : form_limits<shape>()) {
      problem.SetParameterLowerBound(p, own, limits.min);
      problem.SetParameterUpperBound(p, own, limits.max);
      ++own;
    }
  }
}

template <Shape shape>
Parameters<shape> best_parameters(const Cycle& cycle) {
  constexpr std::size_t max_rows = 2000;
  const std::size_t rows = cycle.strain.size();
  const std::size_t stride = 1 + (rows - 1) / max_rows;
  Parameters<shape> best{};
  double min_cost = std::numeric_limits<double>::infinity();
  for (const double start_width_K : {2.0, 6.0, 18.0, 40.0}) {
    Parameters<shape> p = start_parameters<shape>(cycle, start_width_K);
    ceres::Problem problem;
    for (std::size_t i = 0; i < rows; i += stride) {
      problem.AddResidualBlock(
          new ceres::AutoDiffCostFunction<Residual<shape>, 1, shape_parameters(shape)>(
              new Residual<shape>{cycle.temperature_K[i], cycle.strain[i], cycle.stroke,
                                  i > cycle.hottest}),
          nullptr, p.data());
    }
    bound<shape>(problem, p.data());
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::DENSE_NORMAL_CHOLESKY;
    options.max_num_iterations = 200;
    options.function_tolerance = 1e-12;
    options.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
    if (summary.IsSolutionUsable() && summary.final_cost < min_cost) {
      min_cost = summary.final_cost;
      best = p;
    }
  }
  return best;
}

template <Shape shape>
ClassicFit fitted(std::string_view name, const Cycle& cycle) {
  const Parameters<shape> p = best_parameters<shape>(cycle);
  constexpr int other = cooling(shape);
  ClassicFit fit{name,
                 0,
                 0,
                 0,
                 {},
                 p[martensite],
                 p[austenite],
                 p[centre],
                 p[width],
                 p[other + centre],
                 p[other + width]};
  std::vector<double> errors;
  double squares = 0;
  for (std::size_t i = 0; i < cycle.strain.size(); ++i) {
    fit.strain.push_back(strain_at<shape>(p.data(), cycle.temperature_K[i], i > cycle.hottest));
    errors.push_back(std::abs(fit.strain.back() - cycle.strain[i]) / cycle.stroke);
    squares += errors.back() * errors.back();
  }
  std::ranges::rotate(fit.strain, fit.strain.end() - static_cast<std::ptrdiff_t>(cycle.turned));
  fit.rms = std::sqrt(squares / static_cast<double>(errors.size()));
  fit.p95 = quantile(errors, 0.95);
  fit.max = quantile(errors, 1);
  return fit;
}

/// How many rows lead to the coldest one in a run that begins and ends hot, as with an alloy that
/// is austenite at room temperature; otherwise 0.
std::size_t cooled_first(const std::vector<double>& temperature_K) {
  const auto [coldest, hottest] = std::ranges::minmax_element(temperature_K);
  const double warm_K = *hottest - 0.25 * (*hottest - *coldest);
  const bool hot_ends = temperature_K.front() > warm_K && temperature_K.back() > warm_K;
  return hot_ends ? static_cast<std::size_t>(coldest - temperature_K.begin()) + 1 : 0;
}

/// The run as a cycle; none if fits would be meaningless.
std::optional<Cycle> cycle_of(const Run& run) {
  if (run.kind != RunKind::bath || run.strain.empty() || !has_constant_stress(run)) {
    return {};
  }
  Cycle cycle{run.temperature_K, run.strain, cooled_first(run.temperature_K), 0, 0, 0};
  for (std::vector<double>* column : {&cycle.temperature_K, &cycle.strain}) {
    std::ranges::rotate(*column, column->begin() + static_cast<std::ptrdiff_t>(cycle.turned));
  }
  const auto hottest = std::ranges::max_element(cycle.temperature_K);
  cycle.hottest = static_cast<std::size_t>(hottest - cycle.temperature_K.begin());
  const auto [shortest, longest] = std::ranges::minmax(run.strain);
  cycle.shortest = shortest;
  cycle.stroke = longest - shortest;
  if (!(cycle.stroke > 0) || !is_one_cycle(cycle)) {
    return {};
  }
  return cycle;
}

}  // namespace

std::vector<ClassicFit> fit_classics(const Run& run) {
  const std::optional<Cycle> cycle = cycle_of(run);
  if (!cycle) {
    return {};
  }
  return {fitted<Shape::cosine>("cosine", *cycle), fitted<Shape::tanh>("tanh", *cycle),
          fitted<Shape::arctan>("arctan", *cycle)};
}

std::vector<ClassicFit> fit_adaptable(const Run& run) {
  const std::optional<Cycle> cycle = cycle_of(run);
  if (!cycle) {
    return {};
  }
  return {fitted<Shape::bezier>("Bezier", *cycle), fitted<Shape::ihyp>("ihyp", *cycle)};
}

}  // namespace smaservo::identify
