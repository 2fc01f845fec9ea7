#pragma once

#include <Eigen/Core>

namespace smaservo::fits {

/// Minimises |A x - b|² with x[i] >= 0 for i >= free, from the normal equations: `normal` is AᵀA
/// (positive definite), `right` is Aᵀb. Block principal pivoting, after Júdice and Pires (1994):
/// exact except for rounding, in about ten Cholesky decompositions.
Eigen::VectorXd nonnegative_least_squares(const Eigen::MatrixXd& normal,
                                          const Eigen::VectorXd& right, Eigen::Index free);

}  // namespace smaservo::fits
