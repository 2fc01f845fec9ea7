#include "host-sim/papers/fits/nonnegative.hpp"

#include <Eigen/Cholesky>
#include <gtest/gtest.h>
#include <limits>
#include <random>
#include <vector>

namespace smaservo::test {
namespace {

using Eigen::Index;

struct Problem {
  Eigen::MatrixXd normal;
  Eigen::VectorXd right;
};

Problem random_problem(Index unknowns, std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  Eigen::MatrixXd a(unknowns + 3, unknowns);
  for (double& value : a.reshaped()) {
    value = normal(random) + 0.5;
  }
  Eigen::VectorXd b(unknowns + 3);
  for (double& value : b) {
    value = normal(random);
  }
  return {a.transpose() * a, a.transpose() * b};
}

double cost(const Problem& p, const Eigen::VectorXd& x) {
  return 0.5 * x.dot(p.normal * x) - p.right.dot(x);
}

TEST(NonnegativeLeastSquares, IsTheBestOfAllSetsOfUnknownsThatMayBeHeldAtZero) {
  std::mt19937_64 random(1);
  constexpr Index unknowns = 8;
  int held = 0;
  for (int round = 0; round < 200; ++round) {
    const Problem p = random_problem(unknowns, random);
    const Index free = round % 3;
    const Eigen::VectorXd x = fits::nonnegative_least_squares(p.normal, p.right, free);
    double best = std::numeric_limits<double>::infinity();
    for (unsigned set = 0; set < 1U << unknowns; ++set) {
      std::vector<Index> moving;
      for (Index i = 0; i < unknowns; ++i) {
        if (i < free || (set >> i & 1U) != 0) {
          moving.push_back(i);
        }
      }
      Eigen::VectorXd y = Eigen::VectorXd::Zero(unknowns);
      if (!moving.empty()) {
        const Eigen::MatrixXd part = p.normal(moving, moving);
        const Eigen::VectorXd values = part.ldlt().solve(p.right(moving));
        y(moving) = values;
      }
      if ((y.tail(unknowns - free).array() >= 0).all()) {
        best = std::min(best, cost(p, y));
      }
    }
    EXPECT_NEAR(cost(p, x), best, 1e-9 * std::abs(best));
    EXPECT_TRUE((x.tail(unknowns - free).array() >= 0).all());
    held += static_cast<int>((x.tail(unknowns - free).array() == 0).count());
  }
  EXPECT_GT(held, 200);
}

TEST(NonnegativeLeastSquares, MeetsTheConditionsOfTheOptimumWithManyUnknowns) {
  std::mt19937_64 random(2);
  for (int round = 0; round < 5; ++round) {
    const Problem p = random_problem(200, random);
    const Eigen::VectorXd x = fits::nonnegative_least_squares(p.normal, p.right, 1);
    const Eigen::VectorXd slope = p.normal * x - p.right;
    const double scale = p.right.cwiseAbs().maxCoeff();
    EXPECT_NEAR(slope[0], 0, 1e-8 * scale);
    for (Index i = 1; i < 200; ++i) {
      ASSERT_GE(x[i], 0);
      ASSERT_GE(slope[i], -1e-8 * scale);
      ASSERT_NEAR(x[i] * slope[i], 0, 1e-8 * scale);
    }
  }
}

}  // namespace
}  // namespace smaservo::test
