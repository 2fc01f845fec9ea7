#pragma once
// The cells of a Preisach model's grid, whose weights are fitted.

#include <Eigen/Core>
#include <vector>

#include "host-sim/identify/runs/run.hpp"
#include "model/papers/preisach.hpp"

namespace smaservo::fits {

using PreisachNodes = decltype(papers::PreisachParams<double>::node_K);

/// The nodes of the grid, which are close together where the wires transform. Each interval has the
/// same sum of three shares: of the range of temperature, of the change of strain on heating, and
/// of that on cooling.
PreisachNodes placed_nodes(const std::vector<identify::Run>& runs, double shift_K_Pa);

/// Rows of runs, at most 4000 of each: the strain is that of austenite (the first column) plus a
/// sum over the cells' weights, in units of strain.
struct CellRows {
  Eigen::MatrixXd columns;
  Eigen::VectorXd strain, stress_Pa;
};
CellRows cell_rows(const std::vector<identify::Run>& runs, const PreisachNodes& node_K,
                   double shift_K_Pa);

/// Sums up the weights of the cells to F, as shares of the sum over all cells, which is returned.
double sum_up(const Eigen::VectorXd& weights,
              papers::PreisachParams<double>::Increments& increments);

}  // namespace smaservo::fits
