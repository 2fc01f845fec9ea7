#pragma once
// The straight lines of strain over resistance that the augmented Liang-Rogers model implies, for
// heating and for cooling at constant stress. Source: paper 002 section 6, eq. 36 to 49.

#include "model/papers/liang_rogers.hpp"

namespace smaservo::papers {

/// A state in the strain-resistance plane; the resistance relative to R_0 = ρ_M L_0/A_0, that of
/// martensite at the material's reference temperature (002 eq. 17 and 18).
template <class S>
struct ResistancePoint {
  S strain;
  S resistance;
};

/// ε = a λ + b (002 eq. 20 and 21).
template <class S>
struct ResistanceLine {
  S slope, offset;

  constexpr S strain(const S& resistance) const { return slope * resistance + offset; }
};

template <class S>
struct ResistanceBranch {
  ResistancePoint<S> start, finish;
  bool valid;  ///< start and finish differ enough in resistance for the line to mean anything
  ResistanceLine<S> line;
};

/// The ends of both transformations and the lines through them. The cooling line is not valid if
/// R-phase brings the resistance at M_s to within 0.2 % of that at M_f: the line would be vertical.
template <class S>
struct ResistanceLines {
  ResistanceBranch<S> heating, cooling;

  static ResistanceLines at(const typename LiangRogers<S>::Params& kinetics, const Material<S>& m,
                            const S& stress_Pa) {
    const auto point = [&](const CosineProcess<S>& process, const S& zero_stress_K,
                           const Phases<S>& z) {
      const Drive<S> u{zero_stress_K + stress_Pa / process.stress_Pa_K, stress_Pa};
      const S strain = mixed_modulus_strain(m, z, stress_Pa);
      const S rho = resistivity(m, z, u).value / m.martensite.resistivity_ohm_m;
      return ResistancePoint<S>{strain, resistance_ohm(rho, S(1), strain)};
    };
    const Phases<S> martensite{S(1), S(0)};
    const Phases<S> austenite{S(0), S(0)};
    // 002 eq. 48, clamped at its ends if M_s is not between R_s and R_f
    const Drive<S> ms{kinetics.a2m.start_K + stress_Pa / kinetics.a2m.stress_Pa_K, stress_Pa};
    const Phases<S> mixture{S(0), S(1) - cosine_left(kinetics.a2r.progress(ms))};
    // 002 eq. 38 to 41 and 44 to 47. Eq. 44 and 46 contain the whole ε_LR; with a fraction of
    // R-phase it can only be that fraction of ε_LR, as in eq. 29.
    return {through(point(kinetics.m2a, kinetics.m2a.start_K, martensite),
                    point(kinetics.m2a, kinetics.m2a.finish_K, austenite)),
            through(point(kinetics.a2m, kinetics.a2m.start_K, mixture),
                    point(kinetics.a2m, kinetics.a2m.finish_K, martensite))};
  }

 private:
  /// 002 eq. 36, 37, 42 and 43
  static ResistanceBranch<S> through(const ResistancePoint<S>& start,
                                     const ResistancePoint<S>& finish) {
    const S way = finish.resistance - start.resistance;
    const S width = way < S(0) ? -way : way;
    if (width < S(2e-3)) {
      return {start, finish, false, {S(0), S(0)}};
    }
    return {start,
            finish,
            true,
            {(finish.strain - start.strain) / way,
             (start.strain * finish.resistance - finish.strain * start.resistance) / way}};
  }
};

}  // namespace smaservo::papers
