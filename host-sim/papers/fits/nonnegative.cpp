#include "host-sim/papers/fits/nonnegative.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <limits>
#include <vector>

namespace smaservo::fits {
namespace {

using Eigen::Index;

/// The set of variables that are not held at zero, and the gradient of those that are.
class Pivoting {
 public:
  Pivoting(const Eigen::MatrixXd& normal, const Eigen::VectorXd& right, Index free)
      : normal_(normal),
        right_(right),
        free_(free),
        moves_(static_cast<std::size_t>(right.size()), false) {
    std::fill_n(moves_.begin(), free, true);
    tolerance_ = 1e-12 * right.cwiseAbs().maxCoeff();
  }

  Eigen::VectorXd solve() {
    constexpr int max_rounds = 2000;
    // Number of full exchanges that may fail to reduce the number of offenders.
    constexpr int patience = 3;
    Index fewest = std::numeric_limits<Index>::max();
    int left = patience;
    for (int round = 0; round < max_rounds; ++round) {
      update();
      const std::vector<Index> offenders = find_offenders();
      const auto count = static_cast<Index>(offenders.size());
      if (count == 0) {
        break;
      }
      left = count < fewest ? patience : left - 1;
      fewest = std::min(fewest, count);
      if (left >= 0) {
        for (const Index i : offenders) {
          flip(i);
        }
      } else {
        flip(offenders.back());  // Murty's rule, which is certain to terminate
      }
    }
    return x_.cwiseMax(bounded_below());
  }

 private:
  void flip(Index i) { moves_[static_cast<std::size_t>(i)] = !moves_[static_cast<std::size_t>(i)]; }
  bool moves(Index i) const { return moves_[static_cast<std::size_t>(i)]; }

  void update() {
    std::vector<Index> moving;
    for (Index i = 0; i < right_.size(); ++i) {
      if (moves(i)) {
        moving.push_back(i);
      }
    }
    const Eigen::MatrixXd part = normal_(moving, moving);
    const Eigen::VectorXd values = part.llt().solve(right_(moving));
    x_ = Eigen::VectorXd::Zero(right_.size());
    x_(moving) = values;
    slope_ = normal_ * x_ - right_;
  }

  std::vector<Index> find_offenders() const {
    std::vector<Index> all;
    for (Index i = free_; i < right_.size(); ++i) {
      if (moves(i) ? x_[i] < 0 : slope_[i] < -tolerance_) {
        all.push_back(i);
      }
    }
    return all;
  }

  Eigen::VectorXd bounded_below() const {
    Eigen::VectorXd low = Eigen::VectorXd::Zero(right_.size());
    low.head(free_).setConstant(-std::numeric_limits<double>::infinity());
    return low;
  }

  const Eigen::MatrixXd& normal_;
  const Eigen::VectorXd& right_;
  Index free_;
  std::vector<bool> moves_;
  double tolerance_;
  Eigen::VectorXd x_, slope_;
};

}  // namespace

Eigen::VectorXd nonnegative_least_squares(const Eigen::MatrixXd& normal,
                                          const Eigen::VectorXd& right, Eigen::Index free) {
  return Pivoting(normal, right, free).solve();
}

}  // namespace smaservo::fits
