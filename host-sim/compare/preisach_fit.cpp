#include "host-sim/compare/preisach_fit.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>

#include "host-sim/compare/nonnegative.hpp"
#include "host-sim/compare/preisach_slices.hpp"

namespace smaservo {
namespace {

using Model = Preisach<double>;
using Path = Staircase<double, 64>;
using Nodes = decltype(Model::Params::node_K);
constexpr std::size_t nodes = std::tuple_size_v<Nodes>;
constexpr std::size_t cells = (nodes - 1) * nodes / 2;
constexpr std::size_t most_stresses = std::tuple_size_v<decltype(Model::Params::stress_Pa)>;

constexpr std::size_t cell_index(std::size_t hot, std::size_t cold) {
  return hot * (hot + 1) / 2 + cold;
}

/// Where half of the strain has gone on heating and come on cooling, the mean of the two.
double middle_K(const PreisachSlice& slice) {
  const double half = 0.5 * (slice.shortest + slice.longest);
  std::vector<double> down, up;
  for (const Run* run : slice.runs) {
    for (std::size_t i = 1; i < run->strain.size(); ++i) {
      const double before = run->strain[i - 1] - half;
      const double after = run->strain[i] - half;
      if ((before < 0) != (after < 0)) {
        (after < 0 ? down : up).push_back(run->temperature_K[i]);
      }
    }
  }
  return down.empty() || up.empty() ? std::nan("")
                                    : 0.5 * (quantile(down, 0.5) + quantile(up, 0.5));
}

double fitted_shift_K_Pa(const std::vector<PreisachSlice>& slices) {
  double mean_Pa = 0;
  double mean_K = 0;
  for (const PreisachSlice& slice : slices) {
    mean_Pa += slice.stress_Pa / static_cast<double>(slices.size());
    mean_K += middle_K(slice) / static_cast<double>(slices.size());
  }
  double products = 0;
  double squares = 0;
  for (const PreisachSlice& slice : slices) {
    products += (slice.stress_Pa - mean_Pa) * (middle_K(slice) - mean_K);
    squares += (slice.stress_Pa - mean_Pa) * (slice.stress_Pa - mean_Pa);
  }
  return slices.size() > 1 ? products / squares : 0;
}

/// Close together where the wires convert: of all rows' way, a third each by temperature, by
/// strain that goes on heating, and by strain that comes on cooling.
Nodes placed_nodes(const std::vector<PreisachSlice>& slices, double shift_K_Pa) {
  std::array<std::vector<std::pair<double, double>>, 2> moves;  // input, strain
  double low_K = 1e9;
  double high_K = -1e9;
  for (const PreisachSlice& slice : slices) {
    for (const Run* run : slice.runs) {
      const std::vector<double> T = steady_K(run->temperature_K);
      for (std::size_t i = 0; i < T.size(); ++i) {
        const double x = T[i] - shift_K_Pa * slice.stress_Pa;
        low_K = std::min(low_K, x);
        high_K = std::max(high_K, x);
        if (i > 0 && T[i] != T[i - 1]) {
          moves[T[i] < T[i - 1] ? 1 : 0].emplace_back(
              x, std::abs(run->strain[i] - run->strain[i - 1]));
        }
      }
    }
  }
  constexpr std::size_t bins = 1000;
  std::array<double, bins> way{};
  const double bin_K = (high_K - low_K) / bins;
  way.fill(1.0 / bins);
  for (const auto& direction : moves) {
    double all = 0;
    for (const auto& [x, strain] : direction) all += strain;
    for (const auto& [x, strain] : direction) {
      way[std::min(bins - 1, static_cast<std::size_t>((x - low_K) / bin_K))] += strain / all;
    }
  }
  Nodes node_K{};
  node_K.front() = low_K;
  node_K.back() = high_K;
  double sum = 0;
  std::size_t next = 1;
  for (std::size_t bin = 0; bin < bins && next + 1 < nodes; ++bin) {
    const double goal = 3.0 * static_cast<double>(next) / (nodes - 1);
    if (sum + way[bin] >= goal) {
      const double share = (goal - sum) / way[bin];
      // Many goals may lie in one bin; nodes must rise.
      node_K[next] = std::max(low_K + (static_cast<double>(bin) + share) * bin_K,
                              node_K[next - 1] + 0.5 * bin_K);
      ++next;
    }
    sum += way[bin];
  }
  return node_K;
}

/// The share of every cell that lies in the triangle, times the sign.
void add_triangle(const Nodes& node_K, double sign, double hot_K, double cold_K,
                  Eigen::Ref<Eigen::RowVectorXd> row) {
  std::array<double, nodes - 1> below_hot{};
  std::array<double, nodes - 1> above_cold{};
  for (std::size_t i = 0; i + 1 < nodes; ++i) {
    const double width_K = node_K[i + 1] - node_K[i];
    below_hot[i] = std::clamp((hot_K - node_K[i]) / width_K, 0.0, 1.0);
    above_cold[i] = std::clamp((node_K[i + 1] - cold_K) / width_K, 0.0, 1.0);
  }
  for (std::size_t hot = 0; hot + 1 < nodes; ++hot) {
    for (std::size_t cold = 0; cold < hot; ++cold) {
      row[static_cast<Eigen::Index>(cell_index(hot, cold))] +=
          sign * below_hot[hot] * above_cold[cold];
    }
    row[static_cast<Eigen::Index>(cell_index(hot, hot))] +=
        sign * std::max(0.0, below_hot[hot] + above_cold[hot] - 1);
  }
}

/// The strains of a slice as sums over cells; the last column is the strain of austenite.
struct Equations {
  Eigen::MatrixXd rows;
  Eigen::VectorXd strain;
};

Equations equations(const PreisachSlice& slice, const Nodes& node_K, double shift_K_Pa) {
  constexpr std::size_t most_rows = 4000;
  std::size_t count = 0;
  for (const Run* run : slice.runs) count += run->strain.size();
  const std::size_t stride = 1 + (count - 1) / most_rows;
  Equations all{Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(count / stride + slice.runs.size()),
                                      static_cast<Eigen::Index>(cells)),
                {}};
  all.strain = Eigen::VectorXd::Zero(all.rows.rows());
  Eigen::Index at = 0;
  for (const Run* run : slice.runs) {
    const std::vector<double> T = steady_K(run->temperature_K);
    const auto input = [&](std::size_t i) {
      return std::clamp(T[i] - shift_K_Pa * slice.stress_Pa, node_K.front(), node_K.back());
    };
    Path path = Path::cooled(node_K.back(), input(0));
    for (std::size_t i = 0; i < T.size(); ++i) {
      path.move(input(i), [](double hot, double hotter, double cold, double warmer) {
        return (hotter - hot) * (warmer - cold);
      });
      if (i % stride != 0) continue;
      Eigen::RowVectorXd row = Eigen::RowVectorXd::Zero(cells);
      path.each_settled([&](double sign, double hot, double cold) {
        add_triangle(node_K, sign, hot, cold, row);
      });
      const bool heats = path.heats();
      add_triangle(node_K, heats ? -1 : 1, heats ? path.input : path.newest(),
                   heats ? path.newest() : path.input, row);
      all.rows.row(at) = row;
      all.strain[at++] = run->strain[i];
    }
  }
  all.rows.conservativeResize(at, Eigen::NoChange);
  all.strain.conservativeResize(at);
  return all;
}

/// The weights in strain, austenite's strain before them.
Eigen::VectorXd weights(const Equations& e) {
  const Eigen::Index n = e.rows.cols() + 1;
  Eigen::MatrixXd a(e.rows.rows(), n);
  a << Eigen::VectorXd::Ones(e.rows.rows()), e.rows;
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(n, n);
  normal.selfadjointView<Eigen::Lower>().rankUpdate(a.transpose());
  normal = normal.selfadjointView<Eigen::Lower>();
  // As if each weight had been found to be 0 in a fraction of the rows.
  constexpr double pull = 1e-5;
  normal.diagonal().tail(n - 1).array() += pull * static_cast<double>(e.rows.rows());
  return nonnegative_least_squares(normal, a.transpose() * e.strain, 1);
}

/// Sums over the triangles; returns that over all.
double sum_up(const Eigen::VectorXd& weight, Model::Params::Increments& increments) {
  const auto of = [&](std::size_t hot, std::size_t cold) {
    return weight[static_cast<Eigen::Index>(1 + cell_index(hot, cold))];
  };
  const auto F = [&](std::size_t hot, std::size_t cold) {
    return hot > cold ? increments[Model::Params::index(hot, cold)] : 0.0;
  };
  for (std::size_t span = 1; span < nodes; ++span) {
    for (std::size_t cold = 0; cold + span < nodes; ++cold) {
      const std::size_t hot = cold + span;
      const double inner =
          span > 1 ? F(hot - 1, cold) + F(hot, cold + 1) - F(hot - 1, cold + 1) : 0;
      increments[Model::Params::index(hot, cold)] = inner + of(hot - 1, cold);
    }
  }
  return F(nodes - 1, 0);
}

/// The stress' neighbours among those of the model, and the share of the upper one.
struct Between {
  std::size_t low, high;
  double share;
};
Between between(const Model::Params& p, double stress_Pa) {
  std::size_t high = 0;
  while (high + 1 < p.stress_count && p.stress_Pa[high] < stress_Pa) ++high;
  const std::size_t low = high > 0 ? high - 1 : 0;
  const double span_Pa = p.stress_Pa[high] - p.stress_Pa[low];
  return {low, high,
          span_Pa > 0 ? std::clamp((stress_Pa - p.stress_Pa[low]) / span_Pa, 0.0, 1.0) : 0.0};
}

PreisachStrain strains_at(const PreisachWire& wire, double stress_Pa) {
  const Between at = between(wire.kinetics, stress_Pa);
  const PreisachStrain& low = wire.strains[at.low];
  const PreisachStrain& high = wire.strains[at.high];
  return {std::lerp(low.austenite, high.austenite, at.share),
          std::lerp(low.stroke, high.stroke, at.share)};
}

std::vector<double> replayed(const PreisachWire& wire, const Run& run) {
  std::vector<double> strain;
  const std::vector<double> T = steady_K(run.temperature_K);
  Model::State s = Model::rest(wire.kinetics, {T.front(), run.stress_Pa.front()});
  for (std::size_t i = 0; i < T.size(); ++i) {
    Model::advance(wire.kinetics, s, {T[i], run.stress_Pa[i]});
    strain.push_back(wire.strain(s.martensite, run.stress_Pa[i]));
  }
  return strain;
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

PreisachFit fit_preisach(const std::vector<Run>& runs, StressShift shift) {
  const std::vector<PreisachSlice> slices = preisach_slices(runs, most_stresses);
  PreisachFit fit{};
  Model::Params& p = fit.wire.kinetics;
  p.shift_K_Pa = shift == StressShift::fitted ? fitted_shift_K_Pa(slices) : 0;
  p.node_K = placed_nodes(slices, p.shift_K_Pa);
  p.stress_count = slices.size();
  for (std::size_t i = 0; i < slices.size(); ++i) {
    p.stress_Pa[i] = slices[i].stress_Pa;
    const Eigen::VectorXd weight = weights(equations(slices[i], p.node_K, p.shift_K_Pa));
    const double stroke = sum_up(weight, p.increments[i]);
    for (double& increment : p.increments[i]) increment /= stroke;
    fit.wire.strains.push_back({weight[0], stroke});
  }
  double squares = 0;
  std::size_t count = 0;
  for (const Run& run : runs) {
    fit.strain.push_back(replayed(fit.wire, run));
    for (std::size_t i = 0; i < run.strain.size(); ++i) {
      const double stroke = strains_at(fit.wire, run.stress_Pa[i]).stroke;
      squares += std::pow((fit.strain.back()[i] - run.strain[i]) / stroke, 2);
    }
    count += run.strain.size();
  }
  fit.rms = std::sqrt(squares / static_cast<double>(count));
  if (slices.size() == 1) {
    fit.remark = fmt::format(
        "All reversal curves are at {:.0f} MPa: the model is the same under "
        "any stress, and valid at this one only.",
        1e-6 * slices[0].stress_Pa);
  }
  return fit;
}

}  // namespace smaservo
