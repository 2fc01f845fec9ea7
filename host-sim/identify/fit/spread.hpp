#pragma once
// The covariance of a fit's deviations around its solution.

#include <Eigen/Core>
#include <utility>
#include <vector>

#include "host-sim/identify/fit/cost/all_runs_cost.hpp"

namespace smaservo::identify {

class Spread {
 public:
  Spread(std::vector<Active> changing, Eigen::MatrixXd covariance)
      : changing_(std::move(changing)), covariance_(std::move(covariance)) {}

  std::size_t size() const { return changing_.size(); }
  const Active& active(std::size_t i) const { return changing_[i]; }

  /// The variance of a deviation; 0 if it is held.
  double variance(std::size_t i) const {
    const auto at = static_cast<Eigen::Index>(i);
    return covariance_(at, at);
  }

  /// Fixes one deviation at a value, and moves the others to their conditional mean, where they are
  /// most likely with that value.
  void hold(std::size_t i, double value) {
    const auto at = static_cast<Eigen::Index>(i);
    const Eigen::VectorXd gain = covariance_.col(at) / covariance_(at, at);
    const double change = value - *changing_[i].value;
    for (std::size_t k = 0; k < changing_.size(); ++k) {
      *changing_[k].value += gain[static_cast<Eigen::Index>(k)] * change;
    }
    *changing_[i].value = value;
    covariance_ -= covariance_(at, at) * gain * gain.transpose();
    covariance_.row(at).setZero();
    covariance_.col(at).setZero();
  }

 private:
  std::vector<Active> changing_;
  Eigen::MatrixXd covariance_;
};

}  // namespace smaservo::identify
