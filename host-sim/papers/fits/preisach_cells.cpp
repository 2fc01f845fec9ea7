#include "host-sim/papers/fits/preisach_cells.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "host-sim/papers/fits/preisach_slices.hpp"

namespace smaservo::fits {
namespace {

using Path = papers::Staircase<double, 64>;
constexpr std::size_t node_count = std::tuple_size_v<PreisachNodes>;
constexpr std::size_t cells = (node_count - 1) * node_count / 2;

/// The column of a cell; the first column is that of austenite's strain.
constexpr Eigen::Index cell_index(std::size_t hot, std::size_t cold) {
  return static_cast<Eigen::Index>(1 + hot * (hot + 1) / 2 + cold);
}

/// The temperature less the shift by stress, without the reversals caused by noise.
std::vector<double> inputs(const identify::Run& run, double shift_K_Pa) {
  std::vector<double> all(run.temperature_K);
  for (std::size_t i = 0; i < all.size(); ++i) {
    all[i] -= shift_K_Pa * run.stress_Pa[i];
  }
  return steady_K(all);
}

/// Adds the share of every cell that lies in the triangle, times the sign.
void add_triangle(const PreisachNodes& node_K, double sign, double hot_K, double cold_K,
                  Eigen::Ref<Eigen::RowVectorXd> row) {
  std::array<double, node_count - 1> below_hot{};
  std::array<double, node_count - 1> above_cold{};
  for (std::size_t i = 0; i + 1 < node_count; ++i) {
    const double width_K = node_K[i + 1] - node_K[i];
    below_hot[i] = std::clamp((hot_K - node_K[i]) / width_K, 0.0, 1.0);
    above_cold[i] = std::clamp((node_K[i + 1] - cold_K) / width_K, 0.0, 1.0);
  }
  for (std::size_t hot = 0; hot + 1 < node_count; ++hot) {
    for (std::size_t cold = 0; cold < hot; ++cold) {
      row[cell_index(hot, cold)] += sign * below_hot[hot] * above_cold[cold];
    }
    row[cell_index(hot, hot)] += sign * std::max(0.0, below_hot[hot] + above_cold[hot] - 1);
  }
}

}  // namespace

PreisachNodes placed_nodes(const std::vector<identify::Run>& runs, double shift_K_Pa) {
  std::array<std::vector<std::pair<double, double>>, 2> moves;  // input, strain
  double low_K = std::numeric_limits<double>::infinity();
  double high_K = -low_K;
  for (const identify::Run& run : runs) {
    const std::vector<double> x = inputs(run, shift_K_Pa);
    const auto [min, max] = std::ranges::minmax(x);
    low_K = std::min(low_K, min);
    high_K = std::max(high_K, max);
    for (std::size_t i = 1; i < x.size(); ++i) {
      if (x[i] != x[i - 1]) {
        const double moved = std::abs(run.strain[i] - run.strain[i - 1]);
        moves[x[i] < x[i - 1] ? 1 : 0].emplace_back(x[i], moved);
      }
    }
  }
  constexpr std::size_t bins = 1000;
  std::array<double, bins> way{};
  const double bin_K = (high_K - low_K) / bins;
  way.fill(1.0 / bins);
  for (const auto& direction : moves) {
    double all = 0;
    for (const auto& [x, strain] : direction) {
      all += strain;
    }
    for (const auto& [x, strain] : direction) {
      way[std::min(bins - 1, static_cast<std::size_t>((x - low_K) / bin_K))] += strain / all;
    }
  }
  PreisachNodes node_K{};
  node_K.front() = low_K;
  node_K.back() = high_K;
  double sum = 0;
  std::size_t next = 1;
  for (std::size_t bin = 0; bin < bins; ++bin) {
    const auto goal = [&] { return 3.0 * static_cast<double>(next) / (node_count - 1); };
    for (; next + 1 < node_count && sum + way[bin] >= goal(); ++next) {
      node_K[next] = low_K + (static_cast<double>(bin) + (goal() - sum) / way[bin]) * bin_K;
    }
    sum += way[bin];
  }
  return node_K;
}

CellRows cell_rows(const std::vector<identify::Run>& runs, const PreisachNodes& node_K,
                   double shift_K_Pa) {
  constexpr std::size_t max_rows = 4000;
  const auto stride = [](const identify::Run& run) {
    return 1 + (run.strain.size() - 1) / max_rows;
  };
  Eigen::Index count = 0;
  for (const identify::Run& run : runs) {
    count += static_cast<Eigen::Index>((run.strain.size() - 1) / stride(run) + 1);
  }
  CellRows all{Eigen::MatrixXd::Zero(count, static_cast<Eigen::Index>(1 + cells)),
               Eigen::VectorXd(count), Eigen::VectorXd(count)};
  Eigen::Index at = 0;
  Eigen::RowVectorXd row(all.columns.cols());
  for (const identify::Run& run : runs) {
    const std::vector<double> x = inputs(run, shift_K_Pa);
    Path path = Path::cooled(node_K.back(), x[0]);
    for (std::size_t i = 0; i < x.size(); ++i) {
      path.move(x[i], [](double hot, double hotter, double cold, double warmer) {
        return (hotter - hot) * (warmer - cold);
      });
      if (i % stride(run) != 0) {
        continue;
      }
      row.setZero();
      row[0] = 1;
      path.each_settled([&](double sign, double hot, double cold) {
        add_triangle(node_K, sign, hot, cold, row);
      });
      const bool heats = path.heats();
      add_triangle(node_K, heats ? -1 : 1, heats ? path.input : path.newest(),
                   heats ? path.newest() : path.input, row);
      all.columns.row(at) = row;
      all.strain[at] = run.strain[i];
      all.stress_Pa[at++] = run.stress_Pa[i];
    }
  }
  return all;
}

double sum_up(const Eigen::VectorXd& weights,
              papers::PreisachParams<double>::Increments& increments) {
  const auto of = [&](std::size_t hot, std::size_t cold) { return weights[cell_index(hot, cold)]; };
  const auto F = [&](std::size_t hot, std::size_t cold) {
    return hot > cold ? increments[papers::PreisachParams<double>::index(hot, cold)] : 0.0;
  };
  for (std::size_t span = 1; span < node_count; ++span) {
    for (std::size_t cold = 0; cold + span < node_count; ++cold) {
      const std::size_t hot = cold + span;
      const double inner =
          span > 1 ? F(hot - 1, cold) + F(hot, cold + 1) - F(hot - 1, cold + 1) : 0;
      increments[papers::PreisachParams<double>::index(hot, cold)] = inner + of(hot - 1, cold);
    }
  }
  const double all = F(node_count - 1, 0);
  for (double& increment : increments) {
    increment /= all;
  }
  return all;
}

}  // namespace smaservo::fits
