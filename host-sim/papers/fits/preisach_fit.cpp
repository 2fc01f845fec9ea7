#include "host-sim/papers/fits/preisach_fit.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <functional>

#include "host-sim/identify/runs/steady_load.hpp"
#include "host-sim/papers/fits/nonnegative.hpp"
#include "host-sim/papers/fits/preisach_cells.hpp"
#include "host-sim/papers/fits/preisach_slices.hpp"
#include "model/files/error.hpp"

namespace smaservo::fits {
namespace {

using Model = papers::Preisach<double>;
constexpr std::size_t max_stresses = std::tuple_size_v<decltype(Model::Params::stress_Pa)>;

/// The mean of the two temperatures at which the strain is half way, on heating and on cooling.
double middle_K(const PreisachSlice& slice) {
  const double half = 0.5 * (slice.shortest + slice.longest);
  std::vector<double> down, up;
  for (const identify::Run* run : slice.runs) {
    for (std::size_t i = 1; i < run->strain.size(); ++i) {
      const double before = run->strain[i - 1] - half;
      const double after = run->strain[i] - half;
      if ((before < 0) != (after < 0)) {
        (after < 0 ? down : up).push_back(run->temperature_K[i]);
      }
    }
  }
  return down.empty() || up.empty()
             ? std::nan("")
             : 0.5 * (identify::quantile(down, 0.5) + identify::quantile(up, 0.5));
}

double fitted_shift_K_Pa(const std::vector<PreisachSlice>& slices) {
  std::vector<std::pair<double, double>> middles;  // stress, temperature
  for (const PreisachSlice& slice : slices) {
    if (const double T = middle_K(slice); std::isfinite(T)) {
      middles.emplace_back(slice.stress_Pa, T);
    }
  }
  double mean_Pa = 0;
  double mean_K = 0;
  for (const auto& [stress_Pa, T] : middles) {
    mean_Pa += stress_Pa / static_cast<double>(middles.size());
    mean_K += T / static_cast<double>(middles.size());
  }
  double products = 0;
  double squares = 0;
  for (const auto& [stress_Pa, T] : middles) {
    products += (stress_Pa - mean_Pa) * (T - mean_K);
    squares += (stress_Pa - mean_Pa) * (stress_Pa - mean_Pa);
  }
  return middles.size() > 1 ? products / squares : 0;
}

/// The neighbours of a stress among those of the model, and the share of the upper one.
struct Between {
  std::size_t low, high;
  double share;
};
Between between(const Model::Params& p, double stress_Pa) {
  std::size_t high = 0;
  while (high + 1 < p.stress_count && p.stress_Pa[high] < stress_Pa) {
    ++high;
  }
  const std::size_t low = high > 0 ? high - 1 : 0;
  const double span_Pa = p.stress_Pa[high] - p.stress_Pa[low];
  return {low, high,
          span_Pa > 0 ? std::clamp((stress_Pa - p.stress_Pa[low]) / span_Pa, 0.0, 1.0) : 0.0};
}

/// Sums for the least squares; the unknowns of a stress are adjacent, as in CellRows.
struct NormalEquations {
  Eigen::MatrixXd left;
  Eigen::VectorXd right;
};

/// Adds the rows whose stress is between slice `low` and the next one.
void add_rows(const CellRows& rows, const Model::Params& p, std::size_t low,
              NormalEquations& equations) {
  std::vector<Eigen::Index> here;
  std::vector<double> shares;
  for (Eigen::Index i = 0; i < rows.strain.size(); ++i) {
    const Between at = between(p, rows.stress_Pa[i]);
    if (at.low == low) {
      here.push_back(i);
      shares.push_back(at.share);
    }
  }
  const Eigen::Index n = rows.columns.cols();
  const Eigen::ArrayXd upper =
      Eigen::Map<const Eigen::ArrayXd>(shares.data(), static_cast<Eigen::Index>(shares.size()));
  const Eigen::MatrixXd a = rows.columns(here, Eigen::all);
  const Eigen::MatrixXd a_low = (1 - upper).matrix().asDiagonal() * a;
  const Eigen::VectorXd strain = rows.strain(here);
  const auto first = static_cast<Eigen::Index>(low) * n;
  equations.left.block(first, first, n, n) += a_low.transpose() * a_low;
  equations.right.segment(first, n) += a_low.transpose() * strain;
  if (low + 1 < p.stress_count) {
    const Eigen::MatrixXd a_high = upper.matrix().asDiagonal() * a;
    const Eigen::MatrixXd both = a_low.transpose() * a_high;
    equations.left.block(first, first + n, n, n) += both;
    equations.left.block(first + n, first, n, n) += both.transpose();
    equations.left.block(first + n, first + n, n, n) += a_high.transpose() * a_high;
    equations.right.segment(first + n, n) += a_high.transpose() * strain;
  }
}

/// Adds a prior: each weight counts as if measured as 0 in a fraction `pull` of the rows, and as
/// equal to that of the next stress in a fraction `tie`.
void add_beliefs(double rows, double pull, double tie, Eigen::Index n, NormalEquations& equations) {
  Eigen::MatrixXd& left = equations.left;
  for (Eigen::Index i = 0; i < left.rows(); ++i) {
    left(i, i) += i % n == 0 ? 0 : pull * rows;
    const Eigen::Index next = i + n;
    if (next < left.rows()) {
      left(i, i) += tie * rows;
      left(next, next) += tie * rows;
      left(i, next) -= tie * rows;
      left(next, i) -= tie * rows;
    }
  }
}

/// Computes increments and strains. The nodes, the shift and the stresses must be set.
void fit_weights(const CellRows& rows, double tie, PreisachWire& wire) {
  constexpr double pull = 1e-5;
  Model::Params& p = wire.kinetics;
  const Eigen::Index n = rows.columns.cols();
  const Eigen::Index unknowns = static_cast<Eigen::Index>(p.stress_count) * n;
  NormalEquations equations{Eigen::MatrixXd::Zero(unknowns, unknowns),
                            Eigen::VectorXd::Zero(unknowns)};
  for (std::size_t low = 0; low < p.stress_count; ++low) {
    add_rows(rows, p, low, equations);
  }
  add_beliefs(static_cast<double>(rows.strain.size()), pull, tie, n, equations);
  // Austenite's strains may be negative; they are placed first.
  Eigen::VectorX<Eigen::Index> order(unknowns);
  Eigen::Index placed = 0;
  for (const bool austenite : {true, false}) {
    for (Eigen::Index i = 0; i < unknowns; ++i) {
      if ((i % n == 0) == austenite) {
        order[placed++] = i;
      }
    }
  }
  const Eigen::MatrixXd left = equations.left(order, order);
  const Eigen::VectorXd right = equations.right(order);
  Eigen::VectorXd weights(unknowns);
  weights(order) = nonnegative_least_squares(left, right, unknowns / n);
  for (std::size_t i = 0; i < p.stress_count; ++i) {
    const Eigen::VectorXd slice = weights.segment(static_cast<Eigen::Index>(i) * n, n);
    const double stroke = sum_up(slice, p.increments[i]);
    wire.strains.push_back({slice[0], stroke});
  }
}

PreisachStrain strains_at(const PreisachWire& wire, double stress_Pa) {
  const Between at = between(wire.kinetics, stress_Pa);
  const PreisachStrain& low = wire.strains[at.low];
  const PreisachStrain& high = wire.strains[at.high];
  return {std::lerp(low.austenite, high.austenite, at.share),
          std::lerp(low.stroke, high.stroke, at.share)};
}

std::vector<double> replayed(const PreisachWire& wire, const identify::Run& run) {
  std::vector<double> strain;
  const std::vector<double> T = steady_K(run.temperature_K);
  Model::State s = Model::rest(wire.kinetics, {T.front(), run.stress_Pa.front()});
  for (std::size_t i = 0; i < T.size(); ++i) {
    Model::advance(wire.kinetics, s, {T[i], run.stress_Pa[i]});
    strain.push_back(wire.strain(s.martensite, run.stress_Pa[i]));
  }
  return strain;
}

/// Computes the model's strain for the runs to which it was fitted, and its error.
void replay(const std::vector<identify::Run>& runs, PreisachFit& fit) {
  double squares = 0;
  std::size_t count = 0;
  for (const identify::Run& run : runs) {
    fit.strain.push_back(replayed(fit.wire, run));
    for (std::size_t i = 0; i < run.strain.size(); ++i) {
      const double stroke = strains_at(fit.wire, run.stress_Pa[i]).stroke;
      squares += std::pow((fit.strain.back()[i] - run.strain[i]) / stroke, 2);
    }
    count += run.strain.size();
  }
  fit.rms = std::sqrt(squares / static_cast<double>(count));
}

void require_histories(const std::vector<identify::Run>& runs,
                       const std::vector<double>& stresses_Pa) {
  if (runs.empty()) {
    throw files::UserError("no run; the Preisach model needs strain over temperature");
  }
  for (const identify::Run& run : runs) {
    if (run.strain.empty() || run.temperature_K.empty() || run.stress_Pa.empty()) {
      throw files::UserError(fmt::format(
          "{}: the Preisach model needs temperature, stress and strain of every row", run.name));
    }
  }
  if (stresses_Pa.empty() || stresses_Pa.size() > max_stresses ||
      std::ranges::adjacent_find(stresses_Pa, std::greater_equal{}) != stresses_Pa.end()) {
    throw files::UserError(fmt::format("{} stresses, 1 to {} that rise are allowed",
                                       stresses_Pa.size(), max_stresses));
  }
}

}  // namespace

double PreisachWire::strain(double martensite, double stress_Pa) const {
  const PreisachStrain at = strains_at(*this, stress_Pa);
  return at.austenite + martensite * at.stroke;
}

double PreisachWire::increment(double hot_K, double cold_K, double stress_Pa) const {
  const auto inside = [&](double T) {
    return std::clamp(T - kinetics.shift_K_Pa * stress_Pa, kinetics.node_K.front(),
                      kinetics.node_K.back());
  };
  return strains_at(*this, stress_Pa).stroke *
         Model::increment(kinetics, inside(hot_K), inside(cold_K), stress_Pa);
}

PreisachFit fit_preisach(const std::vector<identify::Run>& runs, StressShift shift) {
  const std::vector<PreisachSlice> slices = preisach_slices(runs, max_stresses);
  PreisachFit fit{};
  Model::Params& p = fit.wire.kinetics;
  p.shift_K_Pa = shift == StressShift::fitted ? fitted_shift_K_Pa(slices) : 0;
  p.node_K = placed_nodes(runs, p.shift_K_Pa);
  p.stress_count = slices.size();
  std::ranges::transform(slices, p.stress_Pa.begin(), &PreisachSlice::stress_Pa);
  fit_weights(cell_rows(runs, p.node_K, p.shift_K_Pa), 0, fit.wire);
  replay(runs, fit);
  if (slices.size() == 1) {
    fit.remark = fmt::format(
        "All reversal curves are at {:.0f} MPa: the model is the same under "
        "any stress, and valid at this one only",
        1e-6 * slices[0].stress_Pa);
  }
  return fit;
}

PreisachFit fit_preisach_histories(const std::vector<identify::Run>& runs,
                                   const std::vector<double>& stresses_Pa, double shift_K_Pa) {
  constexpr double tie = 1e-3;
  require_histories(runs, stresses_Pa);
  PreisachFit fit{};
  Model::Params& p = fit.wire.kinetics;
  p.shift_K_Pa = shift_K_Pa;
  p.node_K = placed_nodes(runs, p.shift_K_Pa);
  p.stress_count = stresses_Pa.size();
  std::ranges::copy(stresses_Pa, p.stress_Pa.begin());
  fit_weights(cell_rows(runs, p.node_K, p.shift_K_Pa), tie, fit.wire);
  replay(runs, fit);
  return fit;
}

}  // namespace smaservo::fits
