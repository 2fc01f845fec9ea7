#include "model/papers/duhem_actuator.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <gtest/gtest.h>

#include "model/papers/actuators/actuator_file.hpp"
#include "model/units.hpp"

namespace smaservo::duhem_actuator_test {
namespace {

using Model = papers::DuhemActuator<double>;

constexpr double pi = std::numbers::pi;

class DuhemActuatorTest : public testing::Test {
 protected:
  Model::Params p = papers::load_actuator(std::string(papers::paper_001_actuator));
  double surface_m2 = pi * p.bias.diameter_m * p.bias.length_m;
  double mass_kg =
      p.density_kg_m3 * pi / 4 * p.bias.diameter_m * p.bias.diameter_m * p.bias.length_m;

  double celsius(const Model::State& s) const {
    return Model::output(p, s).temperature_K - zero_degC_K;
  }

  /// Moves the wire by its kinetics alone.
  Model::State at(double celsius, Heading heading) const {
    Model::State s = Model::rest(p);
    if (heading == Heading::cooling) {
      papers::Duhem<double>::advance(p.kinetics, s.kinetics, {500, s.kinetics.drive.stress_Pa});
    }
    papers::Duhem<double>::advance(p.kinetics, s.kinetics,
                                   {celsius + zero_degC_K, s.kinetics.drive.stress_Pa});
    s.heading = heading;
    return s;
  }

  /// How fast the wire goes at a constant power, K/s.
  double rate(double celsius, Heading heading, double power_W) const {
    Model::State s = at(celsius, heading);
    Model::advance(p, s, papers::PowerSource<double>{power_W}, 1e-5);
    return (s.kinetics.drive.temperature_K - celsius - zero_degC_K) / 1e-5;
  }

  void run(Model::State& s, double power_W, double seconds, double dt_s) const {
    const auto steps = std::lround(seconds / dt_s);
    for (long i = 0; i < steps; ++i) {
      Model::advance(p, s, papers::PowerSource<double>{power_W}, dt_s);
    }
  }
};

/// 001 eq. 1 to 3 with Table I's numbers while the temperature rises, in °C; the oracle.
double heated(double celsius, double power_W, double seconds) {
  const double d_0 = 3.81e-4;
  const double L_0 = 0.2286;
  const auto slope = [&](double T) {
    const double h = 165 - 0.5 * T;
    const double c = 1400 + 1000 * std::erf((T - 58) / 0.5);
    return (power_W - pi * d_0 * L_0 * h * (T - 24)) / (6500 * c * pi * d_0 * d_0 * L_0 / 4);
  };
  const int steps = 100000;
  const double dt = seconds / steps;
  for (int i = 0; i < steps; ++i) {
    const double k1 = slope(celsius);
    const double k2 = slope(celsius + dt / 2 * k1);
    const double k3 = slope(celsius + dt / 2 * k2);
    const double k4 = slope(celsius + dt * k3);
    celsius += dt / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
  }
  return celsius;
}

TEST_F(DuhemActuatorTest, NoVoltageChangesNothingToTheBit) {
  Model::State s = Model::rest(p);
  const Model::Output before = Model::output(p, s);
  EXPECT_EQ(before.martensite, 1);
  for (int i = 0; i < 100; ++i) {
    Model::advance(p, s, papers::VoltageSource<double>{0}, 0.02);
  }
  const Model::Output after = Model::output(p, s);
  EXPECT_EQ(before.temperature_K, after.temperature_K);
  EXPECT_EQ(before.martensite, after.martensite);
  EXPECT_EQ(before.resistance_ohm, after.resistance_ohm);
}

TEST_F(DuhemActuatorTest, TemperatureIsTheSolutionToSecondOrder) {
  // 2 W take the wire over the step of the capacity, at 12 K/s before it: no step has substeps.
  const double exact = heated(56, 2, 0.48);
  EXPECT_GT(exact, 58.5);
  double before = 0;
  for (const double dt_s : {0.008, 0.004, 0.002, 0.001}) {
    Model::State s = at(56, Heading::heating);
    run(s, 2, 0.48, dt_s);
    const double error = std::abs(celsius(s) - exact);
    if (before > 0) {
      std::printf("%g s: error %.2g K, order %.2f\n", dt_s, error, std::log2(before / error));
      EXPECT_NEAR(std::log2(before / error), 2, 0.15);
    }
    before = error;
  }
  EXPECT_LT(before, 1e-4);
}

TEST_F(DuhemActuatorTest, VoltagesPowerIsOfSecondOrderToo) {
  // The resistance moves with the temperature, from 24 °C at 9 K/s.
  const auto at_end = [&](double dt_s) {
    Model::State s = Model::rest(p);
    const auto steps = std::lround(1.28 / dt_s);
    for (long i = 0; i < steps; ++i) {
      Model::advance(p, s, papers::VoltageSource<double>{1.2}, dt_s);
    }
    return celsius(s);
  };
  const double exact = at_end(1e-4);
  EXPECT_GT(exact, 28);
  const double coarse = std::abs(at_end(8e-3) - exact);
  const double fine = std::abs(at_end(4e-3) - exact);
  std::printf("errors %.2g and %.2g K\n", coarse, fine);
  EXPECT_NEAR(std::log2(coarse / fine), 2, 0.15);
}

TEST_F(DuhemActuatorTest, EveryTurnCostsAnErrorOfFirstOrder) {
  // At a turn the slope jumps by several K/s, and the step that it falls into does not see it.
  const auto at_turns = [&](double dt_s) {
    Model::State s = Model::rest(p);
    const auto steps = std::lround(60 / dt_s);
    for (long i = 0; i < steps; ++i) {
      const double volt = 1.5 - 1.1 * std::cos(2 * pi / 20 * (static_cast<double>(i) + 0.5) * dt_s);
      Model::advance(p, s, papers::VoltageSource<double>{volt}, dt_s);
    }
    return celsius(s);
  };
  const double exact = at_turns(1e-4);
  for (const double dt_s : {0.02, 0.01, 0.005}) {
    const double error = std::abs(at_turns(dt_s) - exact);
    std::printf("%g s: error %.2g K\n", dt_s, error);
    EXPECT_LT(error, 0.1 * dt_s);
  }
}

TEST_F(DuhemActuatorTest, LongStepsAreMadeOfSubsteps) {
  const double exact = heated(24, 2, 12);
  EXPECT_GT(exact, 62);
  for (const double dt_s : {0.1, 0.5, 4.0}) {
    Model::State s = Model::rest(p);
    run(s, 2, 12, dt_s);
    EXPECT_NEAR(celsius(s), exact, 0.02) << dt_s;
  }
}

TEST_F(DuhemActuatorTest, SettlesWherePowerIsLost) {
  const double power_W = 2;
  Model::State s = Model::rest(p);
  run(s, power_W, 300, 0.05);
  const double T = celsius(s);
  EXPECT_NEAR(surface_m2 * (165 - 0.5 * T) * (T - 24), power_W, 1e-6);
}

TEST_F(DuhemActuatorTest, SlopeFallsAboveAustenitesStart) {
  // 001 section II, figure 4; with h of eq. 2 this is all from eq. 3.
  const double below = rate(56, Heading::heating, 2);
  const double above = rate(60, Heading::heating, 2);
  EXPECT_NEAR(below * 400 * mass_kg, 2 - surface_m2 * 137 * 32, 1e-3);
  EXPECT_LT(above, 0.2 * below);
}

TEST_F(DuhemActuatorTest, SlopeFallsBelowMartensitesStart) {
  // From 55 to 40 °C the distance to the air halves, the slope falls to less than a fifth.
  const double above = rate(55, Heading::cooling, 0);
  const double below = rate(40, Heading::cooling, 0);
  EXPECT_LT(above, 0);
  EXPECT_GT(below / above, 0);
  EXPECT_LT(below / above, 0.25);
}

TEST_F(DuhemActuatorTest, GoesOnInItsDirectionWhereBothWouldDo) {
  // h of eq. 2 is three times as large while cooling: at 80 °C, 3 W heat a wire that heats and let
  // one cool that cools.
  EXPECT_GT(rate(80, Heading::heating, 3), 1);
  EXPECT_LT(rate(80, Heading::cooling, 3), -1);
}

TEST_F(DuhemActuatorTest, StandsWhereNeitherDirectionWouldDo) {
  // Just above the air's 24 °C, h is the larger one while heating.
  const double above_K = 0.5;
  const double power_W = surface_m2 * above_K * 151.5;
  EXPECT_EQ(rate(24 + above_K, Heading::heating, power_W), 0);
  EXPECT_EQ(rate(24 + above_K, Heading::cooling, power_W), 0);
}

TEST_F(DuhemActuatorTest, VoltageHeatsByItsPower) {
  Model::State by_voltage = at(50, Heading::heating);
  Model::State by_power = by_voltage;
  const double ohm = Model::output(p, by_voltage).resistance_ohm;
  Model::advance(p, by_voltage, papers::VoltageSource<double>{2}, 1e-4);
  Model::advance(p, by_power, papers::PowerSource<double>{4 / ohm}, 1e-4);
  EXPECT_NEAR(celsius(by_voltage), celsius(by_power), 1e-8);
  EXPECT_GT(celsius(by_voltage), 50.0005);
}

TEST_F(DuhemActuatorTest, OutputsBelongToEachOther) {
  for (const papers::StrainLaw law : {papers::StrainLaw::balance, papers::StrainLaw::polynomial}) {
    p.strain_law = law;
    for (const Heading heading : {Heading::heating, Heading::cooling}) {
      for (double T = 26; T < 102; T += 4) {
        const Model::Output out = Model::output(p, at(T, heading));
        const double strain = law == papers::StrainLaw::balance
                                  ? p.bias.balanced_strain(out.martensite)
                                  : p.bias.smooth_strain(out.martensite);
        EXPECT_DOUBLE_EQ(out.strain, strain);
        EXPECT_DOUBLE_EQ(out.transformation_strain, strain - p.bias.prestrain());
        EXPECT_DOUBLE_EQ(out.stress_Pa, p.bias.spring_stress_Pa(strain));
        // 001 eq. 20 and 19
        const double ohm_per_rho = 4 * 0.2286 * (1 + 2 * strain) / (pi * 3.81e-4 * 3.81e-4);
        const double R_A = ohm_per_rho * p.resistivity.austenite(T + zero_degC_K, p.ambient_K);
        const double R_M = ohm_per_rho * p.resistivity.martensite(T + zero_degC_K, p.ambient_K);
        EXPECT_NEAR(1 / out.resistance_ohm, (1 - out.martensite) / R_A + out.martensite / R_M,
                    1e-12);
        EXPECT_TRUE(out.temperature_valid && out.strain_valid);
      }
    }
  }
}

papers::DuhemActuator<float>::Params single_precision(const Model::Params& p) {
  const auto f = [](double value) { return static_cast<float>(value); };
  const auto process = [&](const papers::Duhem<double>::Process& from) {
    return papers::Duhem<float>::Process{f(from.centre_K), f(from.deviation_K),
                                         f(from.stress_K_Pa)};
  };
  const auto& b = p.bias;
  const auto& h = p.heat;
  const auto& r = p.resistivity;
  papers::DuhemActuator<float>::Params to{
      {process(p.kinetics.m2a), process(p.kinetics.a2m)},
      {f(b.length_m),
       f(b.diameter_m),
       f(b.spring_N_m),
       f(b.deformation_m),
       f(b.austenite_Pa),
       f(b.twinned_Pa),
       f(b.part_twinned_Pa),
       f(b.detwinned_Pa),
       f(b.yield_strain),
       f(b.detwinned_strain),
       {f(b.smooth[0]), f(b.smooth[1]), f(b.smooth[2])}},
      {f(h.heating_W_m2K), f(h.heating_W_m2K2), f(h.cooling_W_m2K), f(h.cooling_step_W_m2K),
       f(h.cooling_centre_K), f(h.cooling_width_K), f(h.capacity_J_kgK), f(h.capacity_step_J_kgK),
       f(h.capacity_centre_K), f(h.capacity_width_K)},
      {f(r.austenite_ohm_m),
       f(r.austenite_cold_ohm_m),
       f(r.austenite_decay_1_K),
       f(r.step_ohm_m),
       f(r.step_ohm_m_K),
       f(r.step_centre_K),
       f(r.step_width_K),
       {},
       f(r.lowest_K),
       f(r.highest_K)},
      f(p.density_kg_m3),
      f(p.ambient_K),
      p.strain_law};
  std::ranges::transform(r.martensite_ohm_m_K, to.resistivity.martensite_ohm_m_K, f);
  return to;
}

TEST_F(DuhemActuatorTest, FloatsAreGoodEnough) {
  const auto small = single_precision(p);
  Model::State s = Model::rest(p);
  papers::DuhemActuator<float>::State t = papers::DuhemActuator<float>::rest(small);
  double worst_K = 0;
  double worst_strain = 0;
  double worst_R = 0;
  for (int i = 0; i < 6000; ++i) {
    const double volt = 1.5 - 1.1 * std::cos(2 * pi / 2000 * i);
    Model::advance(p, s, papers::VoltageSource<double>{volt}, 0.01);
    papers::DuhemActuator<float>::advance(
        small, t, papers::VoltageSource<float>{static_cast<float>(volt)}, 0.01F);
    const Model::Output exact = Model::output(p, s);
    const papers::DuhemActuator<float>::Output rounded =
        papers::DuhemActuator<float>::output(small, t);
    worst_K = std::max(worst_K,
                       std::abs(static_cast<double>(rounded.temperature_K) - exact.temperature_K));
    worst_strain =
        std::max(worst_strain, std::abs(static_cast<double>(rounded.strain) - exact.strain));
    worst_R = std::max(
        worst_R, std::abs(static_cast<double>(rounded.resistance_ohm) / exact.resistance_ohm - 1));
  }
  std::printf("%.2g K, strain %.2g, resistance %.2g\n", worst_K, worst_strain, worst_R);
  EXPECT_LT(worst_strain, 2e-5);
  EXPECT_LT(worst_R, 2e-4);
}

TEST_F(DuhemActuatorTest, FlagsWhatThePaperDoesNotCover) {
  EXPECT_FALSE(Model::output(p, at(103, Heading::heating)).temperature_valid);
  p.bias.detwinned_strain = 0.101;
  EXPECT_FALSE(Model::output(p, at(24, Heading::heating)).strain_valid);
  EXPECT_TRUE(Model::output(p, at(100, Heading::heating)).strain_valid);
}

}  // namespace
}  // namespace smaservo::duhem_actuator_test
