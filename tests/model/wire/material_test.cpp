#include "model/wire/material.hpp"

#include <ceres/jet.h>
#include <gtest/gtest.h>
#include <random>

#include "tests/model/wire/test_wires.hpp"

namespace smaservo::test::material_test {
namespace {

/// Round numbers, so that a mixture can be worked out by hand.
Material<double> round_material(Mixture mixture) {
  return {{0.04, 25e9, 1.0e-6, 3e-10, 0},
          {0.004, 50e9, 1.0e-6, 2e-10, 1e-16},
          {0, 100e9, 0.8e-6, 2e-10, 1e-16},
          293.15,
          mixture};
}

TEST(Material, StrainIsTheSerialMixture) {
  // Half martensite, a quarter of each other, 100 MPa:
  // 0.5 (0.04 + 0.004) + 0.25 (0.004 + 0.002) + 0.25 (0 + 0.001) = 0.02375
  EXPECT_NEAR(strain(round_material(Mixture::series), {0.5, 0.25}, 100e6), 0.02375, 1e-15);
  EXPECT_NEAR(strain(round_material(Mixture::series), {0.0, 0.0}, 100e6), 0.001, 1e-15);
  EXPECT_NEAR(strain(round_material(Mixture::series), {1.0, 0.0}, 0.0), 0.04, 1e-15);
}

TEST(Material, ResistivityOfBothMixtures) {
  // 100 K above the reference, 200 MPa: M 1.03, R 1.0 + 0.02 + 0.02, A 0.8 + 0.02 + 0.02 uohm m
  const Drive<double> u{393.15, 200e6};
  const Phases<double> z{0.5, 0.25};
  EXPECT_NEAR(resistivity(round_material(Mixture::series), z, u).value,
              (0.5 * 1.03 + 0.25 * 1.04 + 0.25 * 0.84) * 1e-6, 1e-18);
  EXPECT_NEAR(resistivity(round_material(Mixture::parallel), z, u).value,
              1e-6 / (0.5 / 1.03 + 0.25 / 1.04 + 0.25 / 0.84), 1e-18);
}

TEST(Material, PureWireHasThePhasesOwnResistivityInBothMixtures) {
  const Drive<double> u{350, 150e6};
  for (const Phases<double>& z :
       {Phases<double>{1, 0}, Phases<double>{0, 1}, Phases<double>{0, 0}}) {
    EXPECT_NEAR(resistivity(round_material(Mixture::series), z, u).value,
                resistivity(round_material(Mixture::parallel), z, u).value, 1e-20);
  }
}

TEST(Material, DerivativesOfTheResistivityAreTheAutomaticOnes) {
  using J = ceres::Jet<double, 3>;
  std::mt19937_64 random(9);
  std::uniform_real_distribution<double> uniform(0, 1);
  for (const Mixture mixture : {Mixture::series, Mixture::parallel}) {
    const Material<double> m = round_material(mixture);
    const auto phase = [](const Phase<double>& p) {
      return Phase<J>{J(p.strain), J(p.modulus_Pa), J(p.resistivity_ohm_m),
                      J(p.resistivity_ohm_m_K), J(p.resistivity_ohm_m_Pa)};
    };
    const Material<J> n{phase(m.martensite), phase(m.r_phase), phase(m.austenite), J(m.reference_K),
                        mixture};
    for (int i = 0; i < 1000; ++i) {
      const double martensite = uniform(random);
      const double r_phase = (1 - martensite) * uniform(random);
      const Drive<double> u{300 + 120 * uniform(random), 4e8 * uniform(random)};
      const Resistivity<double> got = resistivity(m, {martensite, r_phase}, u);
      const J want = resistivity<J>(n, {J(martensite, 0), J(r_phase, 1)},
                                    {J(u.temperature_K, 2), J(u.stress_Pa)})
                         .value;
      EXPECT_NEAR(got.value, want.a, 1e-20);
      EXPECT_NEAR(got.per_martensite, want.v[0], 1e-19);
      EXPECT_NEAR(got.per_r_phase, want.v[1], 1e-19);
      EXPECT_NEAR(got.per_K, want.v[2], 1e-22);
    }
  }
}

TEST(Material, StrainSlopesAreTheDifferencesOfThePurePhases) {
  const Material<double>& m = paper_wire().material;
  const StrainSlopes<double> by = strain_slopes(m, 150e6);
  const double austenite = strain(m, {0.0, 0.0}, 150e6);
  EXPECT_DOUBLE_EQ(by.austenite, austenite);
  EXPECT_NEAR(by.martensite, strain(m, {1.0, 0.0}, 150e6) - austenite, 1e-17);
  EXPECT_NEAR(by.r_phase, strain(m, {0.0, 1.0}, 150e6) - austenite, 1e-17);
}

TEST(Material, AWireThatStretchesKeepsItsVolume) {
  // Exactly, R = rho L/A with L = L0 (1 + e), A = A0/(1 + e); 000's 1 + 2 e leaves e² out.
  const double rho = 1e-6, length_m = 0.1, area_m2 = 4.5e-9;
  for (const double e : {0.0, 0.01, 0.04, 0.06}) {
    const double exact = rho * length_m * (1 + e) / (area_m2 / (1 + e));
    const double linear = resistance_ohm(rho, length_m / area_m2, e);
    EXPECT_NEAR(exact / linear - 1, e * e / (1 + 2 * e), 1e-12);
  }
}

}  // namespace
}  // namespace smaservo::test::material_test
