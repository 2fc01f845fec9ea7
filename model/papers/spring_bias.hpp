#pragma once
// A wire that pulls against a spring: strain and stress from the fraction of martensite.
// Source: paper 001 section IV, eq. 13 to 18, and its appendix. Martensite detwins under the
// spring's pull, in three straight pieces: twinned, partly twinned, detwinned.

#include <cmath>
#include <numbers>

namespace smaservo::papers {

template <class S>
struct SpringBias {
  S length_m;          ///< L_0, in austenite without load
  S diameter_m;        ///< d_0
  S spring_N_m;        ///< k
  S deformation_m;     ///< Δ, deformation of the spring while the wire is all austenite
  S austenite_Pa;      ///< E_a
  S twinned_Pa;        ///< E_m
  S part_twinned_Pa;   ///< E_T
  S detwinned_Pa;      ///< E_d
  S yield_strain;      ///< ε_m^y, where martensite begins to detwin
  S detwinned_strain;  ///< ε_m^d, where it has ended
  S smooth[3];         ///< k_1, k_2, k_3 of eq. 18

  /// ε_0, the strain at which spring and austenite balance. Requires 16 k Δ <= π d_0² E_a, a spring
  /// that the wire can hold.
  S prestrain() const {
    using std::sqrt;
    // 001 eq. 14
    return S(0.5) - S(0.5) * sqrt(S(1) - S(4) * pull_N() / (section() * austenite_Pa));
  }

  /// The pull of the spring divided by the section of the strained wire, which becomes thinner as
  /// it stretches.
  S spring_stress_Pa(const S& strain) const {
    // 001 eq. 15
    return S(4) * spring_N_m * (deformation_m - length_m * (strain - prestrain())) /
           (section() * (S(1) - strain));
  }

  /// The stress that the phases bear in parallel, each on its own curve (001 fig. 10).
  S wire_stress_Pa(const S& martensite, const S& strain) const {
    S twinned = twinned_Pa * strain;
    if (!(strain < detwinned_strain)) {
      twinned = twinned_Pa * yield_strain + part_twinned_Pa * (detwinned_strain - yield_strain) +
                detwinned_Pa * (strain - detwinned_strain);
    } else if (!(strain < yield_strain)) {
      twinned = twinned_Pa * yield_strain + part_twinned_Pa * (strain - yield_strain);
    }
    // 001 eq. 16
    return (S(1) - martensite) * austenite_Pa * strain + martensite * twinned;
  }

  /// The strain at which both balance; martensite 0..1. Continuous, with kinks at ε_m^y and ε_m^d.
  /// Cost: 2 to 4 square roots.
  S balanced_strain(const S& martensite) const {
    const S first = on_piece(martensite, twinned_Pa, S(0));
    if (first < yield_strain) {
      return first;
    }
    const S to_yield = martensite * yield_strain * (twinned_Pa - part_twinned_Pa);
    const S second = on_piece(martensite, part_twinned_Pa, to_yield);
    if (second < detwinned_strain) {
      return second;
    }
    const S to_detwinned = martensite * detwinned_strain * (part_twinned_Pa - detwinned_Pa);
    return on_piece(martensite, detwinned_Pa, to_yield + to_detwinned);
  }

  /// The same strain as a polynomial with continuous slopes, which the paper fitted below ε_m^d;
  /// with its parameters within 3.5e-4 of balanced_strain().
  S smooth_strain(const S& martensite) const {
    const S second = martensite * martensite;
    const S fourth = second * second;
    const S sixteenth = fourth * fourth * fourth * fourth;
    // 001 eq. 18
    return prestrain() + smooth[0] * martensite + smooth[1] * second +
           smooth[2] * sixteenth * sixteenth * sixteenth * second;
  }

 private:
  S pull_N() const { return S(4) * spring_N_m * deformation_m; }
  /// π d_0², four times the area.
  S section() const { return S(std::numbers::pi) * diameter_m * diameter_m; }

  /// ε where spring and phases balance, martensite being on a piece of this modulus. With
  /// ε = ε_0 + ε_r the phases bear A + B ε, and eq. 15 = eq. 16 reads c ε_r² + d ε_r + e = 0 with
  ///     B = E_a + (E - E_a) R_m,    c = π d_0² B,
  ///     d = -4 k L_0 - c (1 - 2 ε_0) + π d_0² A,
  ///     e = 4 k Δ - π d_0² (1 - ε_0) (A + B ε_0).
  /// That is the appendix, where some brackets are missing; A is 0, R_m (E_m - E_T) ε_m^y, and the
  /// same plus R_m (E_T - E_d) ε_m^d. Eq. 17 prints c_2 for c_3 in its third line. The smaller
  /// root is the wire; d < 0, so it is written without a difference.
  S on_piece(const S& martensite, const S& modulus_Pa, const S& offset_Pa) const {
    using std::sqrt;
    const S strain_0 = prestrain();
    const S B = austenite_Pa + (modulus_Pa - austenite_Pa) * martensite;
    const S c = section() * B;
    const S d = section() * offset_Pa - S(4) * spring_N_m * length_m - c * (S(1) - S(2) * strain_0);
    const S e = pull_N() - section() * (S(1) - strain_0) * (offset_Pa + B * strain_0);
    // 001 eq. 17
    return strain_0 + S(2) * e / (sqrt(d * d - S(4) * c * e) - d);
  }
};

}  // namespace smaservo::papers
