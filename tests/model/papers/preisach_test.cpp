#include "model/papers/preisach.hpp"

#include "tests/model/kinetics_suite.hpp"
#include "tests/model/papers/preisach_relays.hpp"

namespace smaservo::test::preisach_test {
namespace {

struct PreisachDouble {
  using Model = papers::Preisach<double>;
  static Model::Params params() { return relays<double>(0.14); }
  static constexpr InnerLoops loops = InnerLoops::close;
  static constexpr double rounding = 1e-12;
};

struct PreisachFloat : PreisachDouble {
  using Model = papers::Preisach<float>;
  static Model::Params params() { return relays<float>(0.14); }
  static constexpr double rounding = 1e-5;
};

/// Paper 003's own form, in which stress switches no relay: all but the property that loading and
/// unloading at constant temperature take different ways (see below).
struct PreisachOf003 : PreisachDouble {
  static Model::Params params() { return relays<double>(0); }
};

using Both = ::testing::Types<PreisachDouble, PreisachFloat>;
using InDouble = ::testing::Types<PreisachDouble, PreisachOf003>;
using All = ::testing::Types<PreisachDouble, PreisachFloat, PreisachOf003>;
INSTANTIATE_TYPED_TEST_SUITE_P(Preisach, KineticsSuite, Both);
INSTANTIATE_TYPED_TEST_SUITE_P(Preisach, ExactSteps, All);
INSTANTIATE_TYPED_TEST_SUITE_P(Preisach, BranchRates, InDouble);
INSTANTIATE_TYPED_TEST_SUITE_P(Preisach, ReturnPoints, All);
INSTANTIATE_TYPED_TEST_SUITE_P(Preisach, CongruentLoops, InDouble);

using K = papers::Preisach<double>;

template <class Subject>
class PreisachProperties : public KineticsSuite<Subject> {};
TYPED_TEST_SUITE(PreisachProperties, InDouble);

TYPED_TEST(PreisachProperties, PassingATurningPointWipesOutItsLoopToTheBit) {
  double widest = 0;
  for (int i = 0; i < 1000; ++i) {
    K::State straight = this->wandered(30);
    const double stress_MPa = this->uniform(0, 400);
    const double outer_K = this->uniform(290, 420);
    const double turn_K = this->uniform(290, 420);
    const double beyond_K = turn_K + (turn_K - outer_K) * this->uniform(0.01, 1);
    this->move(straight, this->at(outer_K, stress_MPa));
    K::State looped = straight;
    this->move(looped, this->at(turn_K, stress_MPa));
    const K::State turned = looped;
    for (int loop = 0; loop < 3; ++loop) {
      const double back_K = outer_K + (turn_K - outer_K) * this->uniform(0.01, 1);
      this->move(looped, this->at(back_K, stress_MPa));
      widest = std::max(widest, this->difference(looped, turned));
    }
    this->move(looped, this->at(beyond_K, stress_MPa));
    this->move(straight, this->at(beyond_K, stress_MPa));
    for (const double T : {300.0, 400.0, 330.0}) {
      ASSERT_EQ(looped.martensite, straight.martensite) << i;
      this->move(looped, this->at(T, stress_MPa));
      this->move(straight, this->at(T, stress_MPa));
    }
  }
  EXPECT_GT(widest, 0.5);
}

/// Relays with thresholds drawn from the grid's cells: each by its cell's weight, averaged over the
/// stresses, and it counts by how much greater the weight is at the stress of the moment.
class RelaySum {
 public:
  RelaySum(const K::Params& params, int count, std::mt19937_64& random) : params_(params) {
    std::vector<double> weights;
    for (std::size_t hot = 0; hot + 1 < nodes; ++hot) {
      for (std::size_t cold = 0; cold <= hot; ++cold) {
        cells_.push_back({hot, cold});
        double weight = 0;
        for (double stress_MPa = 0; stress_MPa < 401; stress_MPa += 50) {
          weight += cell_weight(cells_.back(), 1e6 * stress_MPa);
        }
        weights.push_back(std::max(weight, 1e-6));
      }
    }
    double all = 0;
    for (const double weight : weights) {
      all += weight;
    }
    std::discrete_distribution<std::size_t> cell(weights.begin(), weights.end());
    std::uniform_real_distribution<double> share(0, 1);
    for (int i = 0; i < count; ++i) {
      const std::size_t c = cell(random);
      const double hot_K = within(cells_[c].hot, share(random));
      const double cold_K =
          cells_[c].hot == cells_[c].cold ? hot_K : within(cells_[c].cold, share(random));
      relays_.push_back({hot_K, cold_K, c, false});
      scale_.push_back(all / weights[c] / count);
    }
  }

  void move(const Drive<double>& u) {
    const double x = u.temperature_K - params_.shift_K_Pa * u.stress_Pa;
    for (Relay& relay : relays_) {
      relay.austenite = relay.austenite ? relay.cold_K < x : relay.hot_K <= x;
    }
  }
  double martensite(double stress_Pa) const {
    std::vector<double> weights(cells_.size());
    std::ranges::transform(cells_, weights.begin(),
                           [&](const Cell& cell) { return cell_weight(cell, stress_Pa); });
    double sum = 0;
    for (std::size_t i = 0; i < relays_.size(); ++i) {
      sum += relays_[i].austenite ? 0 : scale_[i] * weights[relays_[i].cell];
    }
    return sum;
  }

 private:
  static constexpr std::size_t nodes = 24;
  struct Cell {
    std::size_t hot, cold;
  };
  struct Relay {
    double hot_K, cold_K;
    std::size_t cell;
    bool austenite;
  };

  double within(std::size_t cell, double share) const {
    return params_.node_K[cell] + share * (params_.node_K[cell + 1] - params_.node_K[cell]);
  }
  double cell_weight(const Cell& c, double stress_Pa) const {
    const auto F = [&](std::size_t hot, std::size_t cold) {
      return hot > cold
                 ? K::increment(params_, params_.node_K[hot], params_.node_K[cold], stress_Pa)
                 : 0;
    };
    return F(c.hot + 1, c.cold) - F(c.hot, c.cold) - F(c.hot + 1, c.cold + 1) +
           F(c.hot, c.cold + 1);
  }

  K::Params params_;
  std::vector<Cell> cells_;
  std::vector<Relay> relays_;
  std::vector<double> scale_;
};

TYPED_TEST(PreisachProperties, IsTheSumOfItsRelays) {
  RelaySum sum(this->params, 400000, this->random);
  K::State s = K::rest(this->params, this->at(250, 200));
  sum.move(K::drive(s));
  double worst = 0;
  double min = 1;
  double max = 0;
  for (int i = 0; i < 400; ++i) {
    this->move(s, this->wander(K::drive(s)));
    sum.move(K::drive(s));
    const double martensite = K::phases(s).martensite;
    worst = std::max(worst, std::abs(martensite - sum.martensite(K::drive(s).stress_Pa)));
    min = std::min(min, martensite);
    max = std::max(max, martensite);
  }
  std::printf("worst difference from 400000 relays: %.2g\n", worst);
  // A relay counts up to nine times, which makes the mean of so many good to 0.002.
  EXPECT_LT(worst, 0.008);
  EXPECT_LT(min, 0.1);
  EXPECT_GT(max, 0.9);
}

using Suite = KineticsSuite<PreisachDouble>;
class PreisachTest : public Suite {};

TEST_F(PreisachTest, StressOf003WeighsTheRelaysButSwitchesNone) {
  // KineticsSuite's StressTransformsAtConstantTemperature, as 003 eq. 2 has it.
  const K::Params p = relays<double>(0);
  const auto ways = [&](const K::Params& of) {
    K::State s = K::rest(of, at(365, 0));
    std::vector<double> way;
    for (const double stress_MPa : {0.0, 300.0, 500.0, 300.0, 0.0}) {
      K::advance(of, s, at(365, stress_MPa));
      way.push_back(K::phases(s).martensite);
    }
    return way;
  };
  const std::vector<double> kept = ways(p);
  EXPECT_EQ(kept[1], kept[3]);
  EXPECT_EQ(kept[0], kept[4]);
  EXPECT_LT(kept[2], 0.3) << "relays that have become austenite stay so without cooling";
  const std::vector<double> switched = ways(params);
  EXPECT_GT(switched[3], switched[1] + 0.3);
  EXPECT_GT(switched[2], 0.8);
}

TEST_F(PreisachTest, ForgettingTurnsOverLittle) {
  // Loops within loops, more than are remembered, against a memory that has room for all.
  using Deep = papers::Preisach<double, 24, 8, 200>;
  double worst = 0;
  std::size_t deepest = 0;
  for (int walk = 0; walk < 300; ++walk) {
    const double stress_MPa = uniform(0, 400);
    K::State s = K::rest(params, at(450, stress_MPa));
    Deep::State deep = Deep::rest(params, at(450, stress_MPa));
    double low_K = 270 + 0.14 * stress_MPa;
    double high_K = low_K + 120;
    for (int turn = 0; turn < 60; ++turn) {
      const double shrink_K = (high_K - low_K) * uniform(0, 0.2);
      (turn % 2 == 0 ? low_K : high_K) += turn % 2 == 0 ? shrink_K : -shrink_K;
      const Drive<double> u = at(turn % 2 == 0 ? low_K : high_K, stress_MPa);
      move(s, u);
      Deep::advance(params, deep, u);
      worst = std::max(worst, std::abs(s.martensite - deep.martensite));
      deepest = std::max<std::size_t>(deepest, deep.memory.count);
    }
  }
  std::printf("forgetting turns over %.2g\n", worst);
  EXPECT_GT(deepest, 40U);
  EXPECT_LT(worst, 0.02);
}

TEST_F(PreisachTest, IncrementsAreWhatReversalCurvesMeasure) {
  for (int i = 0; i < 500; ++i) {
    const double stress_MPa = uniform(0, 500);
    const double shift_K = 0.14 * stress_MPa;
    const double hot_K = uniform(300, 380);
    const double cold_K = uniform(289, hot_K);
    K::State s = K::rest(params, at(250 + shift_K, stress_MPa));
    move(s, at(hot_K + shift_K, stress_MPa));
    const double turned = s.martensite;
    move(s, at(cold_K + shift_K, stress_MPa));
    EXPECT_NEAR(s.martensite - turned, K::increment(params, hot_K, cold_K, 1e6 * stress_MPa),
                1e-12);
  }
}

TEST_F(PreisachTest, OutsideOfWhatWasIdentifiedItIsFlaggedAndClamped) {
  EXPECT_TRUE(K::valid(params, at(330, 0)));
  EXPECT_TRUE(K::valid(params, at(330 + 70, 500)));
  EXPECT_FALSE(K::valid(params, at(330, -1)));
  EXPECT_FALSE(K::valid(params, at(330 + 70, 501)));
  EXPECT_FALSE(K::valid(params, at(287, 0)));
  EXPECT_FALSE(K::valid(params, at(386, 0)));
  for (const double T : {300.0, 345.0, 370.0, 400.0}) {
    K::State inside = K::rest(params, at(420, 500));
    K::State outside = K::rest(params, at(420, 700));
    move(inside, at(T, 500));
    move(outside, at(T, 700));
    EXPECT_EQ(inside.martensite, outside.martensite);
  }
}

}  // namespace
}  // namespace smaservo::test::preisach_test
