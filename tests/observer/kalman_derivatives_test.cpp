// The filter's derivatives against automatic differentiation of the model, and its covariance
// against dense linear algebra.

#include <Eigen/Dense>
#include <cmath>
#include <gtest/gtest.h>
#include <random>

#include "observer/kalman.hpp"
#include "tests/observer/model_jet.hpp"
#include "tests/observer/simulated_wire.hpp"

namespace smaservo::kalman_derivatives_test {
namespace {

using Filter = KalmanObserver<double>;
using Dense = Eigen::Matrix<double, Filter::size, Filter::size>;
using DenseVector = Eigen::Matrix<double, Filter::size, 1>;

Filter::Params tuned(Mixture mixture = Mixture::series) {
  Wire<double> wire = bench_wire();
  wire.material.mixture = mixture;
  return {plant_params(wire), {}};
}

/// The state with a small change of temperature and phases, history carried along as by the
/// filter's corrections. The outer curves' slopes, which a small shift follows, come from their
/// isobars.
JK::State perturbed(const JK::Params& p, const K::Params& plain, const K::State& s) {
  JK::State to = to_jet(s);
  const double stress_Pa = s.reached.stress_Pa;
  const double m2a = isobar(plain.m2a, stress_Pa).remaining_1_K(s.reverse.m2a);
  const auto cooling =
      isobar(plain.a2m_a2r, Pair<double>(stress_Pa)).remaining_1_K(s.forward.a2m_a2r);
  JK::Tangent tangent{};
  tangent.reverse_1_K = {Jet(m2a), Jet(m2a)};
  tangent.forward_1_K = {Pair<Jet>(Jet(cooling.first()), Jet(cooling.second())),
                         Jet(cooling.first())};
  JK::correct(p, to, tangent, Jet(0.0, Filter::iT),
              {Jet(s.martensite, Filter::iM), Jet(s.r_phase, Filter::iR)});
  return to;
}

/// Nearer than 0.05 K to the turning point that the branch heads for, the rates are bounded.
bool near_turning_point(const K::State& after, const K::Tangent& tangent) {
  const auto near = [](double left, double goal, double slope) {
    return left - goal < 0.05 * std::abs(slope);
  };
  if (after.heading == Heading::heating) {
    return near(after.reverse.m2a, after.hot.newest().left.m2a, tangent.reverse_1_K.m2a);
  }
  const auto left = after.forward.a2m_a2r;
  const auto goal = after.cold.newest().left.a2m_a2r;
  const auto slope = tangent.forward_1_K.a2m_a2r;
  return near(left.first(), goal.first(), slope.first()) ||
         near(left.second(), goal.second(), slope.second());
}

/// A step on a smooth piece of a branch: no reversal, no turning point passed, and more
/// motion of the temperature than of the stress.
bool smooth(const K::State& before, const K::State& after, const Filter::Linear& f) {
  const auto inside = [](double z) { return z > 1e-3; };
  return before.heading == after.heading && before.hot.size() == after.hot.size() &&
         before.cold.size() == after.cold.size() &&
         before.drive.temperature_K == before.reached.temperature_K &&
         after.drive.temperature_K == after.reached.temperature_K &&
         std::abs(after.drive.temperature_K - before.drive.temperature_K) > 1e-3 &&
         !near_turning_point(after, f.tangent) && f.tangent.rates.martensite_1_K < 0 &&
         f.moved.martensite_1_K < 0 && inside(before.martensite) && inside(before.r_phase) &&
         inside(after.martensite) && inside(after.r_phase) &&
         inside(1 - before.martensite - before.r_phase);
}

struct Counts {
  int heating_outer = 0, heating_inner = 0, cooling_outer = 0, cooling_inner = 0;
};

/// The temperature after the step is where the heat balance closes:
/// F = (C + k dt)(T1 - T0) - L_M (M1 - M0) - L_R (R1 - R0) - (P - Q(T0)) dt = const.
Jet balance(const ThermalBody<double>& body, const Filter::State& s, const JK::State& before,
            const JK::State& after, double dt_s) {
  const Jet T0(s.kinetics.drive.temperature_K, Filter::iT);
  const Jet ambient(s.ambient_K, Filter::iAmbient);
  const Jet loss(s.loss, Filter::iLoss);
  const Jet above = T0 - ambient;
  const Jet lost_J = loss * (Jet(body.loss_W_K) + Jet(body.loss_W_K2) * above) * above * Jet(dt_s);
  const Jet loss_J_K = loss * (Jet(body.loss_W_K) + Jet(2 * body.loss_W_K2) * above) * Jet(dt_s);
  return (Jet(body.capacity_J_K) + loss_J_K) * (after.drive.temperature_K - T0) -
         Jet(body.latent_m2a_J) * (after.martensite - before.martensite) -
         Jet(body.latent_r2a_J) * (after.r_phase - before.r_phase) + lost_J;
}

/// The row of the temperature, by the implicit function theorem. Allowed is what the phases may
/// be off, and the change of the loss' slope within the step, which the step leaves out.
void check_temperature(const ThermalBody<double>& body, const Filter::State& s,
                       const Filter::Linear& f, const Jet& F, double dT, double dt_s,
                       double by_before) {
  const auto by = [&](int i) { return -F.v[i] / F.v[iAfter]; };
  const double per = 1 / F.v[iAfter];
  const double latent = (body.latent_m2a_J + body.latent_r2a_J) * per;
  const double bent = 1e-9 + 2.1 * s.loss * body.loss_W_K2 * dt_s * std::abs(dT) * per;
  const double above = std::abs(s.kinetics.drive.temperature_K - s.ambient_K) + std::abs(dT);
  EXPECT_NEAR(f.temperature[Filter::iT], by(Filter::iT), bent + latent * by_before);
  EXPECT_NEAR(f.temperature[Filter::iM], by(Filter::iM), 1e-9);
  EXPECT_NEAR(f.temperature[Filter::iR], by(Filter::iR), 1e-9);
  EXPECT_NEAR(f.temperature[Filter::iAmbient], by(Filter::iAmbient), bent);
  EXPECT_NEAR(f.temperature[Filter::iLoss], by(Filter::iLoss),
              1e-9 + 1.1 * body.loss_slope_W_K(above) * dt_s * std::abs(dT) * per);
  EXPECT_EQ(f.temperature[Filter::iResistance], 0);
}

/// How much of the way to its turning point a step on an inner branch takes.
double loop_share(const K::State& before, const K::State& after) {
  const auto share = [](double was, double is, double goal) {
    return goal < was ? (was - is) / (was - goal) : 0.0;
  };
  if (before.heading == Heading::heating) {
    return share(before.reverse.m2a, after.reverse.m2a, before.hot.newest().left.m2a);
  }
  const auto was = before.forward.a2m_a2r;
  const auto is = after.forward.a2m_a2r;
  const auto goal = before.cold.newest().left.a2m_a2r;
  return std::max(share(was.first(), is.first(), goal.first()),
                  share(was.second(), is.second(), goal.second()));
}

void check_step(const Filter::Params& p, const JK::Params& jp, const Filter::State& s,
                double power_W, double dt_s, Counts& counts) {
  Filter::State after = s;
  const Filter::Linear f = Filter::predict_mean(p, after, power_W, dt_s);
  if (!smooth(s.kinetics, after.kinetics, f)) {
    return;
  }
  const bool heating = s.kinetics.heading == Heading::heating;
  const bool inner = (heating ? s.kinetics.hot.size() : s.kinetics.cold.size()) > 0;
  ++(heating ? (inner ? counts.heating_inner : counts.heating_outer)
             : (inner ? counts.cooling_inner : counts.cooling_outer));

  const JK::State before = perturbed(jp, p.model.kinetics, s.kinetics);
  JK::State moved = before;
  JK::advance(
      jp, moved,
      {Jet(after.kinetics.drive.temperature_K, iAfter), Jet(after.kinetics.drive.stress_Pa)});
  ASSERT_NEAR(moved.martensite.a, after.kinetics.martensite, 1e-12);
  ASSERT_NEAR(moved.r_phase.a, after.kinetics.r_phase, 1e-12);

  const auto& t = f.tangent.transfer;
  const double turned = inner ? loop_share(s.kinetics, after.kinetics) : 0;
  const double exact = 1e-9;
  const auto& M = moved.martensite.v;
  const auto& R = moved.r_phase.v;
  EXPECT_NEAR(t.m_m, M[Filter::iM], exact);
  EXPECT_NEAR(t.m_r, M[Filter::iR], exact);
  EXPECT_NEAR(t.r_m, R[Filter::iM], exact);
  EXPECT_NEAR(t.r_r, R[Filter::iR], exact);

  // On an inner branch T stands for a change of the phases with what the turning points keep, a
  // step back along the branch leaves that as it is.
  const PhaseRates<double>& rates = f.tangent.rates;
  const double rate = std::abs(rates.martensite_1_K) + std::abs(rates.r_phase_1_K);
  const double by_before = exact + 2 * turned * (rate + std::abs(f.moved.martensite_1_K));
  EXPECT_NEAR(rates.martensite_1_K, M[iAfter], exact);
  EXPECT_NEAR(rates.r_phase_1_K, R[iAfter], exact);
  EXPECT_NEAR(f.moved.martensite_1_K, -M[Filter::iT], by_before);
  EXPECT_NEAR(f.moved.r_phase_1_K, -R[Filter::iT], by_before);

  check_temperature(p.model.body, s, f, balance(p.model.body, s, before, moved, dt_s),
                    after.kinetics.drive.temperature_K - s.kinetics.drive.temperature_K, dt_s,
                    by_before);
}

TEST(KalmanDerivatives, PredictionAgainstAutomaticDifferentiation) {
  const Filter::Params p = tuned();
  const JK::Params jp = to_jet(p.model.kinetics);
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> uniform;
  Counts counts;
  for (int run = 0; run < 40; ++run) {
    double stress_Pa = 20e6 + 280e6 * uniform(random);
    const Measurement<double> first{20, 0.01, 0, stress_Pa, true, true, true};
    const double ambient_K = 290 + 20 * uniform(random);
    // From cold, or from austenite: then the first cooling is on the outer branch.
    Filter::State s = Filter::start(p, first, ambient_K);
    if (run % 4 >= 2) {
      Filter::start(p, s, first, ambient_K, hot_K(stress_Pa), {0.01, 0.01}, 0.05, 4);
    }
    s.loss = 0.8 + 0.4 * uniform(random);
    const double full_W = holding_W(hot_K(stress_Pa));
    double level = run % 4 < 2 ? 1.1 : 0.05;
    int left = 3000;
    for (int i = 0; i < 12000; ++i) {
      if (--left < 0) {
        level = uniform(random);
        left = 200 + static_cast<int>(1500 * uniform(random));
      }
      stress_Pa += run % 2 == 0 ? 0 : 2e3 * (uniform(random) - 0.5);
      s.stress_Pa = stress_Pa;
      if (i % 7 == 0) {
        check_step(p, jp, s, level * full_W, sample_s, counts);
        if (HasFatalFailure() || HasNonfatalFailure()) {
          FAIL() << "run " << run << ", step " << i << " at " << s.kinetics.drive.temperature_K
                 << " K, " << stress_Pa << " Pa, M " << s.kinetics.martensite << ", R "
                 << s.kinetics.r_phase << ", hot " << s.kinetics.hot.size() << ", cold "
                 << s.kinetics.cold.size();
        }
      }
      Filter::predict_mean(p, s, level * full_W, sample_s);
    }
  }
  EXPECT_GE(counts.heating_outer, 500);
  EXPECT_GE(counts.heating_inner, 500);
  EXPECT_GE(counts.cooling_outer, 500);
  EXPECT_GE(counts.cooling_inner, 500);
}

/// A state in range, with nothing in common with its neighbours.
Filter::State anywhere(const Filter::Params& p, std::mt19937_64& random) {
  std::uniform_real_distribution<double> uniform;
  const double martensite = uniform(random);
  const Phases<double> z{martensite, (1 - martensite) * uniform(random)};
  const Measurement<double> m{20, 0.01, 0, 400e6 * uniform(random), true, true, true};
  Filter::State s;
  Filter::start(p, s, m, 270 + 50 * uniform(random), 280 + 150 * uniform(random), z,
                0.02 + 0.1 * uniform(random), 1 + 5 * uniform(random));
  s.resistance = 0.98 + 0.04 * uniform(random);
  s.loss = 0.7 + 0.6 * uniform(random);
  return s;
}

/// The plant's formula for the resistance, by temperature, phases and ambient temperature.
Jet resistance_of(const Filter::Params& p, const Material<Jet>& material, const Filter::State& s) {
  const Jet ambient(s.ambient_K, Filter::iAmbient);
  const Jet T(s.kinetics.drive.temperature_K, Filter::iT);
  const auto& ends = p.model.ends;
  const auto mixed = [&](const Jet& middle, const Jet& end) {
    return Jet(1 - ends.share) * middle + Jet(ends.share) * end;
  };
  const Phases<Jet> z{mixed(Jet(s.kinetics.martensite, Filter::iM), ends.phases.martensite),
                      mixed(Jet(s.kinetics.r_phase, Filter::iR), ends.phases.r_phase)};
  const Drive<Jet> u{mixed(T, ambient), s.stress_Pa};
  return resistance_ohm<Jet>(resistivity(material, z, u).value, p.model.length_per_area_1_m,
                             strain(material, z, u.stress_Pa));
}

TEST(KalmanDerivatives, ExpectedResistanceAgainstAutomaticDifferentiation) {
  for (const Mixture mixture : {Mixture::series, Mixture::parallel}) {
    const Filter::Params p = tuned(mixture);
    const Material<Jet> material = to_jet(p.model.material);
    std::mt19937_64 random(5);
    for (int i = 0; i < 2000; ++i) {
      const Filter::State s = anywhere(p, random);
      const Filter::Expected e = Filter::expected(p, s);
      const Jet resistance(s.resistance, Filter::iResistance);
      const Jet ohm = resistance * resistance_of(p, material, s);
      ASSERT_NEAR(ohm.a, e.ohm, 1e-12 * e.ohm);
      for (int k = 0; k < Filter::size; ++k) {
        ASSERT_NEAR(e.slope[k], ohm.v[k], 1e-12 * e.ohm) << "by state " << k;
      }
      // The estimate's resistance and strain are those of the plant's formulas.
      const Estimate<double> estimate = Filter::estimate(p, s);
      const Phases<double> z = p.model.ends.average(K::phases(s.kinetics));
      ASSERT_NEAR(estimate.strain, strain(p.model.material, z, s.stress_Pa), 1e-15);
    }
  }
}

Dense matrix_of(const Filter::State& s) {
  Dense P;
  for (int i = 0; i < Filter::size; ++i) {
    for (int j = 0; j < Filter::size; ++j) {
      P(i, j) = s.covariance.at(i, j);
    }
  }
  return P;
}

/// F of the whole state, from the parts that predict_mean() gives.
Dense transition(const Filter::Linear& f) {
  Dense F = Dense::Identity();
  F.row(Filter::iT) = f.temperature.head<Filter::size>();
  const auto& t = f.tangent.transfer;
  F.row(Filter::iM) = f.tangent.rates.martensite_1_K * F.row(Filter::iT);
  F.row(Filter::iR) = f.tangent.rates.r_phase_1_K * F.row(Filter::iT);
  F(Filter::iM, Filter::iM) += t.m_m;
  F(Filter::iM, Filter::iR) += t.m_r;
  F(Filter::iM, Filter::iT) -= f.moved.martensite_1_K;
  F(Filter::iR, Filter::iM) += t.r_m;
  F(Filter::iR, Filter::iR) += t.r_r;
  F(Filter::iR, Filter::iT) -= f.moved.r_phase_1_K;
  return F;
}

/// Products of the deviations: what the entries of a covariance are measured by.
Dense scale_of(const Dense& P) {
  const DenseVector sd = P.diagonal().cwiseSqrt();
  return sd * sd.transpose();
}

double difference(const Dense& a, const Dense& b, const Dense& scale) {
  return ((a - b).array() / scale_of(scale).array()).abs().maxCoeff();
}

Filter::State with_covariance(Filter::State s, const Dense& P) {
  for (int i = 0; i < Filter::size; ++i) {
    for (int j = 0; j < Filter::size; ++j) {
      s.covariance.at(i, j) = P(i, j);
    }
  }
  return s;
}

// Without a measurement P = F P F' + Q with a Q that does not depend on P and is a covariance; a
// measurement takes (P H)(P H)'/variance from that.
TEST(KalmanDerivatives, CovarianceAgainstDenseAlgebra) {
  const Filter::Params p = tuned();
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  LumpedWire wire(random_deviations(random), 150e6, 4);
  Profile profile(150e6, 5);
  Filter::State s = Filter::start(p, wire.step(0.01), told_ambient_K);
  for (int i = 0; i < 20000; ++i) {
    const Measurement<double> m = wire.step(profile.power_W(i * sample_s));
    Measurement<double> blind = m;
    blind.resistance_valid = false;

    Filter::State predicted = s;
    Filter::advance(p, predicted, blind, sample_s);
    Filter::State mean = s;
    mean.stress_Pa = predicted.stress_Pa;
    const Dense F = transition(Filter::predict_mean(p, mean, m.power_W, sample_s));
    const Dense P = matrix_of(s);
    const Dense Q = matrix_of(predicted) - F * P * F.transpose();
    const Dense noise = Q.array() / scale_of(P).array();
    ASSERT_GT(noise.selfadjointView<Eigen::Lower>().eigenvalues().minCoeff(), -1e-9);

    const Dense wider =
        P + Dense::NullaryExpr([&] { return 0.2 * normal(random); }).cwiseProduct(scale_of(P));
    const Dense symmetric = (wider + wider.transpose()) / 2;
    Filter::State other = with_covariance(s, symmetric);
    Filter::advance(p, other, blind, sample_s);
    ASSERT_LT(difference(matrix_of(other), F * symmetric * F.transpose() + Q, P), 1e-9);

    const Filter::Expected e = Filter::expected(p, mean);
    const DenseVector H = e.slope.head<Filter::size>().transpose();
    const DenseVector PH = matrix_of(predicted) * H;
    Filter::advance(p, s, m, sample_s);
    ASSERT_NEAR(s.innovation_ohm, m.resistance_ohm - e.ohm, 1e-12 * e.ohm);
    ASSERT_GT(s.innovation_variance, H.dot(PH) + m.resistance_sd_ohm * m.resistance_sd_ohm);
    ASSERT_LT(difference(matrix_of(s),
                         matrix_of(predicted) - PH * PH.transpose() / s.innovation_variance, P),
              1e-9)
        << "at " << i << " ms";
  }
}

}  // namespace
}  // namespace smaservo::kalman_derivatives_test
