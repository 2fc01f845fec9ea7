#include "model/plants/sublayers.hpp"

#include "tests/model/kinetics_suite.hpp"

namespace smaservo::test::sublayers_test {
namespace {

/// About what the 76 um wire's surfaces give.
constexpr SublayerSpread spread{{347.0, 5.8, 3.2, 0.1325e-6, 0},
                                {313.5, 8.0, 3.0, 0.15e-6, -2.5e-17},
                                {344.0, 5.8, 3.2, 0.1325e-6, 0},
                                {333.5, 8.0, 3.0, 0.01e-6, 0},
                                0.6,
                                -0.6,
                                1.5,
                                1};

struct SublayersDouble {
  using Model = Sublayers<double>;
  static Model::Params params() { return Model::params(spread); }
  static constexpr InnerLoops loops = InnerLoops::close;
  static constexpr double rounding = 1e-12;
};

struct SublayersFloat : SublayersDouble {
  using Model = Sublayers<float>;
  static Model::Params params() { return Model::params(spread); }
  static constexpr double rounding = 1e-5;
};

using Both = ::testing::Types<SublayersDouble, SublayersFloat>;
using InDouble = ::testing::Types<SublayersDouble>;
INSTANTIATE_TYPED_TEST_SUITE_P(Sublayers, KineticsSuite, Both);
INSTANTIATE_TYPED_TEST_SUITE_P(Sublayers, ExactSteps, Both);
INSTANTIATE_TYPED_TEST_SUITE_P(Sublayers, BranchRates, InDouble);
INSTANTIATE_TYPED_TEST_SUITE_P(Sublayers, ReturnPoints, Both);
// Of martensite, which is a sum of plays; R-phase is a share of what martensite leaves.
INSTANTIATE_TYPED_TEST_SUITE_P(Sublayers, CongruentLoops, InDouble);

using K = Sublayers<double>;

class SublayersTest : public KineticsSuite<SublayersDouble> {
 protected:
  double turning_K() { return uniform(290, 420); }
};

TEST_F(SublayersTest, PassingATurningPointWipesOutItsLoopToTheBit) {
  double widest = 0;
  for (int i = 0; i < 1000; ++i) {
    State straight = wandered(30);
    const double stress_MPa = uniform(0, 400);
    const double outer_K = turning_K();
    const double turn_K = turning_K();
    const double beyond_K = turn_K + (turn_K - outer_K) * uniform(0.01, 1);
    move(straight, at(outer_K, stress_MPa));
    State looped = straight;
    move(looped, at(turn_K, stress_MPa));
    const State turned = looped;
    for (int loop = 0; loop < 3; ++loop) {
      move(looped, at(outer_K + (turn_K - outer_K) * uniform(0, 1), stress_MPa));
      widest = std::max(widest, difference(looped, turned));
    }
    move(looped, at(beyond_K, stress_MPa));
    move(straight, at(beyond_K, stress_MPa));
    ASSERT_EQ(looped.martensite, straight.martensite) << i;
    ASSERT_EQ(looped.r_phase_part, straight.r_phase_part) << i;
  }
  EXPECT_GT(widest, 0.5);
}

TEST_F(SublayersTest, EveryLayerIsAPlayOperatorWhateverTheStep) {
  // As the header states it, for all layers at every step; the model looks at few of them. At high
  // stress A2M comes to lie above M2A in some layers, and L holds there.
  const K::Params p = K::params({{347.0, 5.8, 3.2, 0.1325e-6, 0},
                                 {313.5, 8.0, 3.0, 0.17e-6, 0},
                                 {344.0, 5.8, 3.2, 0.1325e-6, 0},
                                 {333.5, 8.0, 3.0, 0.16e-6, 0},
                                 0.6,
                                 -0.6,
                                 1.5,
                                 1});
  const auto ramp = [](double x) { return std::clamp(x, 0.0, 1.0); };
  const auto felt_K = [](const K::Thresholds& t, const Drive<double>& u) {
    return u.temperature_K - u.stress_Pa * t.per_Pa - u.stress_Pa * u.stress_Pa * t.per_Pa2;
  };
  int crossed = 0;
  const auto play = [&](const K::Thresholds& hot, const K::Thresholds& cold, const Drive<double>& u,
                        double& x, std::size_t i) {
    const double U = ramp(1 - (felt_K(hot, u) - hot.at_K[i]) / p.ramp_K);
    const double L = ramp((cold.at_K[i] - felt_K(cold, u)) / p.ramp_K);
    crossed += U + 1e-9 < L ? 1 : 0;
    x = std::max(L, std::min(U, x));
  };
  State s = K::rest(p, {300, 0});
  State all = s;
  for (int n = 0; n < 20'000; ++n) {
    // Long and short steps of the temperature, of the stress and of both.
    const double reach = std::pow(10, uniform(-3, 2));
    Drive<double> u = K::drive(s);
    u.temperature_K += n % 3 == 0 ? 0 : reach * uniform(-1, 1);
    u.stress_Pa += n % 3 == 1 ? 0 : 5e6 * reach * uniform(-1, 1);
    u = {std::clamp(u.temperature_K, 280.0, 460.0), std::clamp(u.stress_Pa, 0.0, 700e6)};
    K::advance(p, s, u);
    Phases<double> sum{0, 0};
    for (std::size_t i = 0; i < all.martensite.size(); ++i) {
      play(p.m2a, p.a2m, u, all.martensite[i], i);
      play(p.r2a, p.a2r, u, all.r_phase_part[i], i);
      ASSERT_NEAR(s.martensite[i], all.martensite[i], 1e-12) << n;
      ASSERT_NEAR(s.r_phase_part[i], all.r_phase_part[i], 1e-12) << n;
      sum.martensite += all.martensite[i] / 40;
      sum.r_phase += (1 - all.martensite[i]) * all.r_phase_part[i] / 40;
    }
    ASSERT_NEAR(K::phases(s).martensite, sum.martensite, 1e-12) << n;
    ASSERT_NEAR(K::phases(s).r_phase, sum.r_phase, 1e-12) << n;
  }
  EXPECT_GT(crossed, 1000);
}

TEST_F(SublayersTest, MartensiteNeverBecomesRPhase) {
  double lost = 0;
  double passed = 0;
  for (int walk = 0; walk < 100; ++walk) {
    State s = wandered(0);
    for (int i = 0; i < 500; ++i) {
      const Phases<double> before = K::phases(s);
      const Drive<double> u = K::drive(s);
      const Drive<double> next = wander(u, false);
      move(s, next);
      const double r_phase = K::phases(s).r_phase - before.r_phase;
      const double martensite = K::phases(s).martensite - before.martensite;
      if (u.temperature_K < next.temperature_K) {
        ASSERT_LE(r_phase, 1e-12);
        ASSERT_LE(martensite, 1e-12);
        lost = std::max(lost, -martensite);
      } else {
        ASSERT_GE(martensite, -1e-12);
        passed = std::max(passed, r_phase);
      }
    }
  }
  EXPECT_GT(lost, 0.5);
  EXPECT_GT(passed, 0.5);
}

TEST_F(SublayersTest, ThresholdsAreTheQuantilesWhateverTheSeed) {
  SublayerSpread other = spread;
  other.seed = 99;
  const K::Params p = K::params(spread);
  const K::Params q = K::params(other);
  EXPECT_NE(p.a2m.at_K, q.a2m.at_K);
  EXPECT_EQ(p.m2a.at_K, q.m2a.at_K);
  const auto sorted = [](K::PerLayer all) {
    std::ranges::sort(all);
    return all;
  };
  EXPECT_EQ(sorted(p.a2m.at_K), sorted(q.a2m.at_K));
  // A logistic scale is where the odds are e: 27 % below the median, 73 % above.
  const auto share_below = [](const K::PerLayer& all, double T) {
    return static_cast<double>(std::ranges::count_if(all, [&](double at) { return at < T; })) / 40;
  };
  EXPECT_NEAR(share_below(p.a2m.at_K, 313.5 - 8), 0.269, 0.02);
  EXPECT_NEAR(share_below(p.a2m.at_K, 313.5), 0.5, 0.02);
  EXPECT_NEAR(share_below(p.a2m.at_K, 313.5 + 3), 0.731, 0.02);
}

TEST_F(SublayersTest, RanksOfColdThresholdsAreCorrelatedAsAsked) {
  const auto correlation = [](const K::PerLayer& a, const K::PerLayer& b) {
    double less = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        less += (a[i] < a[j]) == (b[i] < b[j]) ? 1 : -1;
      }
    }
    return less / 780;  // Kendall's rank correlation over 780 pairs
  };
  double m = 0;
  double r = 0;
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    SublayerSpread s = spread;
    s.seed = seed;
    s.a2r.median_K = 300;  // so low that no threshold gives way to another
    const K::Params p = K::params(s);
    m += correlation(p.m2a.at_K, p.a2m.at_K) / 50;
    r += correlation(p.a2m.at_K, p.a2r.at_K) / 50;
  }
  // Kendall's is 2/π arcsin of the correlation for normal scores: 0.41 for 0.6.
  EXPECT_NEAR(m, 0.41, 0.05);
  EXPECT_NEAR(r, -0.41, 0.05);
}

}  // namespace
}  // namespace smaservo::test::sublayers_test
