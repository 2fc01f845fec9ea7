#include "observer/kalman.hpp"

#include <Eigen/Dense>
#include <cmath>
#include <gmock/gmock.h>
#include <limits>
#include <vector>

#include "tests/observer/float_params.hpp"
#include "tests/observer/simulated_wire.hpp"

namespace smaservo::kalman_test {
namespace {

using Filter = KalmanObserver<double>;
using Dense = Eigen::Matrix<double, Filter::size, Filter::size>;

static_assert(StrainObserver<KalmanObserver<double>>);
static_assert(StrainObserver<KalmanObserver<float>>);

Filter::Params tuned() {
  return {plant_params(bench_wire()), {}};
}

template <class S>
Dense matrix_of(const typename KalmanObserver<S>::State& s) {
  Dense P;
  for (int i = 0; i < Filter::size; ++i) {
    for (int j = 0; j < Filter::size; ++j) {
      P(i, j) = static_cast<double>(s.covariance.at(i, j));
    }
  }
  return P;
}

/// The covariance as a correlation: of numbers about 1, whatever the units.
Dense correlation(const Dense& P) {
  const auto sd = P.diagonal().array().sqrt().matrix().eval();
  return (P.array() / (sd * sd.transpose()).array()).matrix();
}

Measurement<float> to_float(const Measurement<double>& m) {
  return {static_cast<float>(m.resistance_ohm),
          static_cast<float>(m.resistance_sd_ohm),
          static_cast<float>(m.power_W),
          static_cast<float>(m.stress_Pa),
          m.resistance_valid,
          m.power_valid,
          m.stress_valid};
}

double mean(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) {
    sum += value;
  }
  return sum / static_cast<double>(values.size());
}

void expect_between(double value, double low, double high, const char* what) {
  EXPECT_GE(value, low) << what;
  EXPECT_LE(value, high) << what;
}

void expect_on_simplex(const Phases<double>& z, double slack) {
  EXPECT_GE(z.martensite, -slack);
  EXPECT_GE(z.r_phase, -slack);
  EXPECT_GE(z.austenite(), -slack);
}

/// The greatest asymmetry and the least eigenvalue met in a run, both of the correlation.
struct Soundness {
  double asymmetry = 0;
  double min_eigenvalue = 1;
};

template <class S>
void add(Soundness& to, const typename KalmanObserver<S>::State& s) {
  const Dense P = correlation(matrix_of<S>(s));
  to.asymmetry = std::max(to.asymmetry, (P - P.transpose()).cwiseAbs().maxCoeff());
  const Dense symmetric = (P + P.transpose()) / 2;
  to.min_eigenvalue = std::min(
      to.min_eigenvalue, Eigen::SelfAdjointEigenSolver<Dense>(symmetric, Eigen::EigenvaluesOnly)
                             .eigenvalues()
                             .minCoeff());
}

// At the first sample a warm room and a drift of the resistance look alike; a heating tells them
// apart.
TEST(Kalman, TellsAWarmRoomFromADriftOfTheResistance) {
  const Filter::Params p = tuned();
  std::vector<double> drift_errors, strain_errors;
  for (const double stress_Pa : {20e6, 40e6}) {
    for (const double warmer_K : {-9.0, 9.0}) {
      for (const double drift : {0.99, 1.01}) {
        Deviations deviations;
        deviations.ambient_K = warmer_K;
        deviations.resistance = drift;
        LumpedWire wire(deviations, stress_Pa, 5);
        const double heating_W = holding_W(hot_K(stress_Pa));
        Filter::State s = Filter::start(p, wire.step(0.01), told_ambient_K);
        for (int i = 0; i < 12000; ++i) {
          const bool heats = i > 1000 && i < 6000;
          Filter::advance(p, s, wire.step(heats ? heating_W : 0.002), sample_s);
        }
        drift_errors.push_back(100 * std::abs(s.resistance - drift));
        strain_errors.push_back(2500 * std::abs(Filter::estimate(p, s).strain - wire.strain()));
      }
    }
  }
  std::printf("off by %.3f %% of the resistance, %.2f %% of the stroke\n", mean(drift_errors),
              mean(strain_errors));
  expect_between(mean(drift_errors), 0.01, 0.2, "drift");
  expect_between(mean(strain_errors), 0.1, 2.5, "strain");
}

TEST(Kalman, CovarianceStaysSoundAndFractionsOnTheSimplex) {
  const Filter::Params p = tuned();
  const KalmanObserver<float>::Params pf = to_float(p);
  Soundness in_double, in_float;
  for (const double stress_Pa : {30e6, 120e6, 250e6}) {
    std::mt19937_64 random(static_cast<std::uint64_t>(stress_Pa));
    LumpedWire wire(random_deviations(random), stress_Pa, 1);
    Profile profile(stress_Pa, 2);
    const Measurement<double> first = wire.step(0.01);
    Filter::State s = Filter::start(p, first, told_ambient_K);
    auto sf = KalmanObserver<float>::start(pf, to_float(first), float(told_ambient_K));
    for (int i = 0; i < 60000; ++i) {
      const Measurement<double> m = wire.step(profile.power_W(i * sample_s));
      Filter::advance(p, s, m, sample_s);
      KalmanObserver<float>::advance(pf, sf, to_float(m), float(sample_s));
      if (i % 10 == 0) {
        add<double>(in_double, s);
        add<float>(in_float, sf);
        expect_on_simplex(ThreePhase<double>::phases(s.kinetics), 1e-12);
        expect_on_simplex({double(sf.kinetics.martensite), double(sf.kinetics.r_phase)}, 1e-5);
      }
      ASSERT_FALSE(HasFailure()) << "at " << i << " ms, " << stress_Pa << " Pa";
    }
  }
  EXPECT_LT(in_double.asymmetry, 1e-9);
  EXPECT_GT(in_double.min_eigenvalue, -1e-9);
  EXPECT_LT(in_float.asymmetry, 1e-3);
  EXPECT_GT(in_float.min_eigenvalue, -1e-3);
}

TEST(Kalman, WithoutResistanceItIsTheModelAndGetsNoSurer) {
  const Filter::Params p = tuned();
  LumpedWire wire({}, 150e6, 1);
  Profile profile(150e6, 2);
  Measurement<double> m = wire.step(0.01);
  Filter::State s = Filter::start(p, m, told_ambient_K);
  const double start_sd = Filter::estimate(p, s).strain_sd;
  m.resistance_ohm = std::numeric_limits<double>::quiet_NaN();
  m.resistance_sd_ohm = std::numeric_limits<double>::quiet_NaN();
  m.resistance_valid = false;
  for (int i = 0; i < 20000; ++i) {
    const Filter::State before = s;
    m.power_W = profile.power_W(i * sample_s);
    Filter::advance(p, s, m, sample_s);
    ASSERT_TRUE(matrix_of<double>(s).allFinite());
    ASSERT_TRUE(std::isfinite(Filter::estimate(p, s).strain));
    ASSERT_EQ(s.innovation_ohm, 0);
    ASSERT_EQ(s.resistance, 1);
    ASSERT_EQ(s.loss, 1);
    ASSERT_EQ(s.ambient_K, told_ambient_K);
    // States about which nothing is learnt only become less certain.
    for (const int slow : {Filter::iAmbient, Filter::iLoss, Filter::iResistance}) {
      ASSERT_GT(s.covariance.at(slow, slow), before.covariance.at(slow, slow));
    }
  }
  // In the middle of the next transformation the filter is less certain than at rest in the cold.
  double widest = 0;
  for (int i = 0; i < 3000; ++i) {
    m.power_W = holding_W(hot_K(150e6));
    Filter::advance(p, s, m, sample_s);
    widest = std::max(widest, Filter::estimate(p, s).strain_sd);
  }
  EXPECT_GT(widest, 2 * start_sd);
}

TEST(Kalman, WithResistanceItGetsSurer) {
  const Filter::Params p = tuned();
  LumpedWire wire({}, 150e6, 1);
  LumpedWire same({}, 150e6, 1);
  Profile profile(150e6, 2);
  Filter::State with = Filter::start(p, wire.step(0.01), told_ambient_K);
  Filter::State without = with;
  same.step(0.01);
  int surer = 0;
  for (int i = 0; i < 12000; ++i) {
    Measurement<double> m = wire.step(profile.power_W(i * sample_s));
    Filter::advance(p, with, m, sample_s);
    m.resistance_valid = false;
    Filter::advance(p, without, m, sample_s);
    surer += Filter::estimate(p, with).strain_sd < Filter::estimate(p, without).strain_sd ? 1 : 0;
  }
  EXPECT_GE(surer, 11000);
  EXPECT_LT(with.covariance.at(Filter::iResistance, Filter::iResistance),
            0.25 * without.covariance.at(Filter::iResistance, Filter::iResistance));
}

// The same inputs through both for a minute, as shares of the nominal stroke.
// The worst is a reversal that one of them sees a millisecond later: measured 0.8 %, mean 0.04 %.
TEST(Kalman, FloatFollowsDouble) {
  const Filter::Params p = tuned();
  const KalmanObserver<float>::Params pf = to_float(p);
  double worst = 0;
  double worst_mean = 0;
  for (const double stress_Pa : {50e6, 150e6, 300e6}) {
    std::mt19937_64 random(17);
    LumpedWire wire(random_deviations(random), stress_Pa, 3);
    Profile profile(stress_Pa, 4);
    const Measurement<double> first = wire.step(0.01);
    Filter::State s = Filter::start(p, first, told_ambient_K);
    auto sf = KalmanObserver<float>::start(pf, to_float(first), float(told_ambient_K));
    double sum = 0;
    for (int i = 0; i < 60000; ++i) {
      const Measurement<double> m = wire.step(profile.power_W(i * sample_s));
      Filter::advance(p, s, m, sample_s);
      KalmanObserver<float>::advance(pf, sf, to_float(m), float(sample_s));
      const double difference = std::abs(Filter::estimate(p, s).strain -
                                         double(KalmanObserver<float>::estimate(pf, sf).strain)) /
                                0.04;
      worst = std::max(worst, difference);
      sum += difference;
    }
    worst_mean = std::max(worst_mean, sum / 60000);
  }
  EXPECT_LT(worst, 0.02);
  expect_between(worst_mean, 1e-7, 1e-3, "mean difference");
}

/// A bias of the innovation is blamed on the air where the load stands still, and while it changes
/// only if it is larger: then the model itself may be wrong by so much.
TEST(Kalman, AChangingLoadExplainsABias) {
  const Filter::Params p = tuned();
  Measurement<double> m{20, 0.01, 0.05, 150e6, false, true, true};
  Filter::State s = Filter::start(p, m, told_ambient_K);
  const auto run = [&](double seconds, double Pa_s) {
    for (int i = 0; i < static_cast<int>(seconds / sample_s); ++i) {
      m.stress_Pa += Pa_s * sample_s;
      Filter::advance(p, s, m, sample_s);
    }
  };
  for (const double slope_Pa_s : {100e6, -100e6}) {
    for (const double sign : {1.0, -1.0}) {
      run(5, 0);
      s.bias = sign * 1.5 * p.tuning.resistance_bias;
      EXPECT_TRUE(Filter::strayed(p, s, 1));
      run(1, slope_Pa_s);
      EXPECT_FALSE(Filter::strayed(p, s, 1));
      s.bias = sign * 4 * p.tuning.resistance_bias;
      EXPECT_TRUE(Filter::strayed(p, s, 1));
      s.bias = sign * 1.5 * p.tuning.resistance_bias;
      run(3, 0);
      EXPECT_TRUE(Filter::strayed(p, s, 1));
    }
  }
}

/// Errors of the strain after the first second, in % of the nominal stroke and by the filter's own
/// deviation.
struct Errors {
  std::vector<double> percent, by_sd;
};

template <class Wire>
void observe(double stress_Pa, std::uint64_t seed, double seconds, Errors& errors) {
  const Filter::Params p = tuned();
  std::mt19937_64 random(seed);
  Wire wire(random_deviations(random), stress_Pa, seed);
  Profile profile(stress_Pa, seed + 1);
  Filter::State s = Filter::start(p, wire.step(0.01), told_ambient_K);
  for (int i = 0; i < static_cast<int>(seconds / sample_s); ++i) {
    Filter::advance(p, s, wire.step(profile.power_W(i * sample_s)), sample_s);
    if (i > 1000 && i % 10 == 0) {
      const Estimate<double> e = Filter::estimate(p, s);
      const double error = std::abs(e.strain - wire.strain());
      errors.percent.push_back(error / 0.04 * 100);
      errors.by_sd.push_back(error / e.strain_sd);
    }
  }
}

TEST(Kalman, ErrorsAreAsLargeAsItSays) {
  Errors lumped, distributed;
  std::uint64_t seed = 100;
  for (const double stress_Pa : {100e6, 150e6, 200e6, 300e6}) {
    for (int i = 0; i < 6; ++i) {
      observe<LumpedWire>(stress_Pa, ++seed, 30, lumped);
    }
    observe<DistributedWire>(stress_Pa, ++seed, 30, distributed);
  }
  // The means were measured as 0.41 and 0.78 %. Much smaller ones would show that the wires do not
  // test the filter.
  expect_between(mean(lumped.percent), 0.1, 0.8, "mean error, lumped");
  expect_between(mean(distributed.percent), 0.2, 1.3, "mean error, distributed");
  EXPECT_LT(quantile(lumped.percent, 1), 6);
  EXPECT_LT(quantile(distributed.percent, 1), 6);
  // An exact filter has 95 % of its errors within 1.96 standard deviations. This one allows for
  // errors of the model, so its standard deviations are larger than needed: the quantiles were
  // measured as 0.73 and 1.01.
  expect_between(quantile(lumped.by_sd, 0.95), 0.3, 1.5, "95 % by deviation, lumped");
  expect_between(quantile(distributed.by_sd, 0.95), 0.5, 1.96, "95 % by deviation, distributed");
}

}  // namespace
}  // namespace smaservo::kalman_test
