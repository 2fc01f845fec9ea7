#pragma once
// The cells of a Preisach model's grid, whose weights are what is fitted.

#include <Eigen/Core>
#include <vector>

#include "host-sim/identify/runs/run.hpp"
#include "model/papers/preisach.hpp"

namespace smaservo::fits {

using PreisachNodes = decltype(papers::PreisachParams<double>::node_K);

/// Close together where the wires convert: of all rows' way, a third each by temperature, by
/// strain that goes on heating, and by strain that comes on cooling.
PreisachNodes placed_nodes(const std::vector<identify::Run>& runs, double shift_K_Pa);

/// Rows of runs: the strain is austenite's (the first column) and a sum over the cells' weights, in
/// strain. At most 4000 of each run.
struct CellRows {
  Eigen::MatrixXd columns;
  Eigen::VectorXd strain, stress_Pa;
};
CellRows cell_rows(const std::vector<identify::Run>& runs, const PreisachNodes& node_K,
                   double shift_K_Pa);

/// F, as a share of the sum over all cells, from weights as the columns have them; returns that
/// sum.
double sum_up(const Eigen::VectorXd& weights,
              papers::PreisachParams<double>::Increments& increments);

}  // namespace smaservo::fits
