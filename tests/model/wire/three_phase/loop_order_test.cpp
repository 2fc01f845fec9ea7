#include "model/wire/three_phase/loop_order.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <gtest/gtest.h>
#include <limits>
#include <random>
#include <vector>

#include "model/wire/three_phase/three_phase.hpp"
#include "tests/model/wire/test_wires.hpp"

namespace smaservo::test::loop_order_test {
namespace {

/// C(v, q) by bisection of the equation that defines it: C (1 - v - q + C) = θ (v - C) (q - C).
double joint(double odds, double v, double q) {
  double low = std::max(0.0, v + q - 1);
  double high = std::min(v, q);
  for (int i = 0; i < 60; ++i) {
    const double c = 0.5 * (low + high);
    (c * (1 - v - q + c) < odds * (v - c) * (q - c) ? low : high) = c;
  }
  return 0.5 * (low + high);
}

class LoopOrderTest : public ::testing::Test {
 protected:
  double uniform(double low = 0, double high = 1) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  double odds() { return std::pow(10, uniform(-1, 2)); }

  std::mt19937_64 random_{44};
};

TEST_F(LoopOrderTest, IsPlackettsCopula) {
  for (int i = 0; i < 20000; ++i) {
    const double theta = odds(), v = uniform(), q = uniform();
    const LoopOrder<double> order{theta - 1, q};
    ASSERT_NEAR(order(v), joint(theta, v, q), 1e-12) << theta << ' ' << v << ' ' << q;
    ASSERT_NEAR(order(v), (LoopOrder<double>{theta - 1, v}(q)), 1e-14);
    ASSERT_NEAR(order.inverse(order(v)), v, 1e-11);
    // What is not there: the same copula of the other shares.
    ASSERT_NEAR(1 - v - q + order(v), (LoopOrder<double>{theta - 1, 1 - q}(1 - v)), 1e-13);
    const double h = 1e-6 * std::min(v, 1 - v);
    ASSERT_NEAR(order.slope(v), (order(v + h) - order(v - h)) / (2 * h), 1e-5);
    ASSERT_GE(order.slope(v), 0);
    ASSERT_LE(order.slope(v), 1);
  }
}

TEST_F(LoopOrderTest, IsNothingOnAnOuterBranchAndWithIndependentOrders) {
  for (int i = 0; i < 1000; ++i) {
    const double v = uniform();
    for (const LoopOrder<double>& order :
         {LoopOrder<double>{0, uniform()}, LoopOrder<double>{odds() - 1, 1}}) {
      EXPECT_FALSE(order.matters());
      EXPECT_EQ(order(v), v);
      EXPECT_EQ(order.slope(v), 1);
      EXPECT_EQ(order.inverse(v), v);
    }
    // Without that exception: v q, of which a branch needs ratios only.
    const double q = uniform();
    EXPECT_NEAR((LoopOrder<double>{1e-13, q}(v)), v * q, 1e-12);
    EXPECT_NEAR((LoopOrder<double>{odds() - 1, 1 - 1e-13}(v)), v, 1e-11);
  }
}

TEST_F(LoopOrderTest, LastComesFirstWithGreatOdds) {
  for (int i = 0; i < 1000; ++i) {
    const double v = uniform(), q = uniform();
    EXPECT_NEAR((LoopOrder<double>{1e6, q}(v)), std::min(v, q), 1.1e-3);
  }
}

TEST_F(LoopOrderTest, FloatKeepsTheDigitsOfTheSmallerShare) {
  double worst = 0;
  for (int i = 0; i < 100000; ++i) {
    const double theta = odds();
    const auto v = static_cast<float>(std::pow(10, uniform(-6, 0)));
    const auto q = static_cast<float>(std::pow(10, uniform(-6, 0)));
    const float c = LoopOrder<float>{static_cast<float>(theta - 1), q}(v);
    const double exact = LoopOrder<double>{static_cast<double>(static_cast<float>(theta - 1)),
                                           static_cast<double>(q)}(static_cast<double>(v));
    worst = std::max(worst, std::abs(static_cast<double>(c) / exact - 1));
  }
  std::printf("worst relative error %.2g\n", worst);
  EXPECT_LT(worst, 4e-6);  // where θ is 0.1, of which a float has six digits less 1
}

/// A wire of many parts, each a relay with a rank in A2M and one in M2A. It is what the model is to
/// be, and knows of no ratio, turning point or branch.
class Parts {
 public:
  /// Stratified: the first ranks are n equal steps, the second ones the quantiles given the first.
  Parts(double odds, int n) {
    for (int i = 0; i < n; ++i) {
      const double u_0 = static_cast<double>(i) / n;
      const double u_1 = static_cast<double>(i + 1) / n;
      for (int k = 0; k < n; ++k) {
        const double goal = (k + 0.5) / n / n;
        double low = 0;
        double high = 1;
        for (int turn = 0; turn < 40; ++turn) {
          const double v = 0.5 * (low + high);
          (joint(odds, u_1, v) - joint(odds, u_0, v) < goal ? low : high) = v;
        }
        parts_.push_back({0.5 * (u_0 + u_1), 0.5 * (low + high), false});
      }
    }
  }

  /// Moves to where the outer curves have these shares left.
  void move(double a2m_left, double m2a_left) {
    for (Part& part : parts_) {
      if (part.in_a2m < 1 - a2m_left) {
        part.martensite = true;
      } else if (!(part.in_m2a < m2a_left)) {
        part.martensite = false;
      }
    }
  }
  double martensite() const {
    return static_cast<double>(std::ranges::count_if(parts_, &Part::martensite)) /
           static_cast<double>(parts_.size());
  }

 private:
  struct Part {
    double in_a2m, in_m2a;
    bool martensite;
  };
  std::vector<Part> parts_;
};

TEST_F(LoopOrderTest, TheWireIsOneOfManyPartsWithTwoThresholdsEach) {
  using K = ThreePhase<double, 24>;
  constexpr int n = 100;
  for (const double theta : {0.2, 1.0, 8.0, 60.0}) {
    K::Params p = ordered_kinetics();
    p.smallest_reversal_K = 0;
    p.loop_odds = theta;
    double worst = 0;
    double paper = 0;
    for (int walk = 0; walk < 4; ++walk) {
      const double stress_Pa = uniform(0, 400e6);
      const Isobar<double> a2m = first_isobar(isobar(p.a2m_a2r, Pair<double>(stress_Pa)));
      const Isobar<double> m2a = isobar(p.m2a, stress_Pa);
      Parts parts(theta, n);
      K::Params plain = p;
      plain.loop_odds = 1;
      K::State s = K::rest(p, {450, stress_Pa});
      K::State without = K::rest(plain, {450, stress_Pa});
      for (int leg = 0; leg < 60; ++leg) {
        const double T = a2m.start_K - 20 + uniform(0, m2a.start_K - a2m.start_K + 40);
        K::advance(p, s, {T, stress_Pa});
        K::advance(plain, without, {T, stress_Pa});
        parts.move(a2m.remaining(T), m2a.remaining(T));
        worst = std::max(worst, std::abs(s.martensite - parts.martensite()));
        paper = std::max(paper, std::abs(without.martensite - parts.martensite()));
      }
    }
    std::printf("odds %4.1f: worst difference %.4f, of the paper's scaling %.3f\n", theta, worst,
                paper);
    // The parts are steps of 1/n; two edges of a loop lie within one each.
    EXPECT_LT(worst, 2.0 / n) << theta;
    if (theta != 1) {
      EXPECT_GT(paper, 5.0 / n) << theta;
    }
  }
}

}  // namespace
}  // namespace smaservo::test::loop_order_test
