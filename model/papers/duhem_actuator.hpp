#pragma once
// The complete actuator of paper 001: a wire heated by a current, pulling against a spring. Voltage
// or power in; temperature, martensite, strain, stress and resistance out.

#include <cmath>
#include <numbers>

#include "model/papers/duhem.hpp"
#include "model/papers/duhem_resistivity.hpp"
#include "model/papers/spring_bias.hpp"
#include "model/units.hpp"
#include "model/wire/material.hpp"

namespace smaservo::papers {

/// Convection that depends on direction, and a heat capacity that rises where austenite begins,
/// which is the paper's substitute for latent heat. The paper's temperatures are in °C.
template <class S>
struct DuhemHeat {
  S heating_W_m2K;        ///< a_1, h at 0 °C while the temperature rises
  S heating_W_m2K2;       ///< a_2, decrease of h per kelvin
  S cooling_W_m2K;        ///< a_3, mean of the two levels of h while the temperature falls
  S cooling_step_W_m2K;   ///< a_4, half the step between the two levels
  S cooling_centre_K;     ///< m_1
  S cooling_width_K;      ///< n_1
  S capacity_J_kgK;       ///< b_1, mean of the two levels of the heat capacity
  S capacity_step_J_kgK;  ///< b_2, half the step between them
  S capacity_centre_K;    ///< m_2
  S capacity_width_K;     ///< n_2

  S convection_W_m2K(const S& temperature_K, Heading heading) const {
    using std::erf;
    // 001 eq. 2
    return heading == Heading::heating
               ? heating_W_m2K - heating_W_m2K2 * (temperature_K - S(zero_degC_K))
               : cooling_W_m2K +
                     cooling_step_W_m2K * erf((temperature_K - cooling_centre_K) / cooling_width_K);
  }

  S specific_heat_J_kgK(const S& temperature_K) const {
    using std::erf;
    // 001 eq. 3
    return capacity_J_kgK +
           capacity_step_J_kgK * erf((temperature_K - capacity_centre_K) / capacity_width_K);
  }
};

/// The source that drives the current.
template <class S>
struct VoltageSource {
  S voltage_V;
  S power_W(const S& resistance_ohm) const { return voltage_V * voltage_V / resistance_ohm; }
};
template <class S>
struct PowerSource {
  S constant_W;
  S power_W(const S& /*resistance_ohm*/) const { return constant_W; }
};

/// How strain is computed: by the balance of forces (eq. 17) or by the polynomial (eq. 18).
enum class StrainLaw : unsigned char { balance, polynomial };

template <class S>
struct DuhemActuator {
  struct Params {
    typename Duhem<S>::Params kinetics;
    SpringBias<S> bias;
    DuhemHeat<S> heat;
    DuhemResistivity<S> resistivity;
    S density_kg_m3;
    S ambient_K;
    StrainLaw strain_law;
  };

  struct State {
    typename Duhem<S>::State kinetics;
    Heading heading;
  };

  struct Output {
    S temperature_K;
    S martensite;
    S strain;                 ///< ε
    S transformation_strain;  ///< ε_r
    S stress_Pa;
    S resistance_ohm;
    bool temperature_valid;  ///< the temperature is within the range of martensite's resistivity
    bool strain_valid;       ///< the strain is below ε_m^d; the paper has no equations beyond it
  };

  /// A wire at the ambient temperature that is all martensite, as 001 eq. 12 begins. (A wire that
  /// was cooled to 24 °C keeps 4 % of austenite by Table I.)
  static State rest(const Params& p) { return {{drive(p, p.ambient_K), S(1)}, Heading::heating}; }

  static Output output(const Params& p, const State& s) {
    const S T = s.kinetics.drive.temperature_K;
    const S strain = strain_of(p, s);
    return {T,
            s.kinetics.martensite,
            strain,
            strain - p.bias.prestrain(),
            p.bias.spring_stress_Pa(strain),
            resistance(p, s),
            p.resistivity.valid(T),
            strain < p.bias.detwinned_strain};
  }

  /// dt_s > 0, meant for 0.1 to 100 ms. The midpoint rule: the error is of second order in dt_s
  /// while the temperature moves one way, and of first order at each turn, where h jumps. A step
  /// that would move the temperature by more than 0.1 K (0.2 of the width over which the heat
  /// capacity changes) is divided into substeps. Cost of a substep: 2 steps of Duhem, 2
  /// resistances.
  template <class Source>
  static void advance(const Params& p, State& s, const Source& source, const S& dt_s) {
    const S rate = rate_K_s(p, s, source);
    const S move_K = (rate < S(0) ? -rate : rate) * dt_s;
    int parts = 1;
    while (parts < 1024 && S(0.1) * S(parts) < move_K) {
      parts *= 2;
    }
    for (int part = 0; part < parts; ++part) {
      advance_part(p, s, source, dt_s / S(parts));
    }
  }

 private:
  /// The transformation is driven by the stress of the prestrained wire, independent of the strain:
  /// 001 section III neglects the difference.
  static Drive<S> drive(const Params& p, const S& temperature_K) {
    return {temperature_K, p.bias.austenite_Pa * p.bias.prestrain()};
  }

  static S strain_of(const Params& p, const State& s) {
    return p.strain_law == StrainLaw::balance ? p.bias.balanced_strain(s.kinetics.martensite)
                                              : p.bias.smooth_strain(s.kinetics.martensite);
  }

  static S area_m2(const Params& p) {
    return S(0.25 * std::numbers::pi) * p.bias.diameter_m * p.bias.diameter_m;
  }

  static S resistance(const Params& p, const State& s) {
    const S resistivity =
        p.resistivity.parallel(s.kinetics.martensite, s.kinetics.drive.temperature_K, p.ambient_K);
    // 001 eq. 19
    return resistance_ohm(resistivity, p.bias.length_m / area_m2(p), strain_of(p, s));
  }

  // 001 eq. 1
  template <class Source>
  static S rate_K_s(const Params& p, const State& s, const Source& source, Heading heading) {
    const S T = s.kinetics.drive.temperature_K;
    const S surface_m2 = S(std::numbers::pi) * p.bias.diameter_m * p.bias.length_m;
    const S loss_W = surface_m2 * p.heat.convection_W_m2K(T, heading) * (T - p.ambient_K);
    const S capacity_J_K =
        p.density_kg_m3 * area_m2(p) * p.bias.length_m * p.heat.specific_heat_J_kgK(T);
    return (source.power_W(resistance(p, s)) - loss_W) / capacity_J_K;
  }

  /// The rate of the temperature. Its sign gives the heading, which h depends on (eq. 2): a heading
  /// is consistent if the rate computed with it has its sign. The present heading is kept if it is
  /// consistent, otherwise the other one is tried; if neither is consistent, the temperature stands
  /// still.
  template <class Source>
  static S rate_K_s(const Params& p, State& s, const Source& source) {
    const auto agrees = [](const S& rate, Heading heading) {
      return heading == Heading::heating ? !(rate < S(0)) : rate < S(0);
    };
    const S same = rate_K_s(p, s, source, s.heading);
    if (agrees(same, s.heading)) {
      return same;
    }
    const Heading turned = s.heading == Heading::heating ? Heading::cooling : Heading::heating;
    const S other = rate_K_s(p, s, source, turned);
    if (!agrees(other, turned)) {
      return S(0);
    }
    s.heading = turned;
    return other;
  }

  template <class Source>
  static void advance_part(const Params& p, State& s, const Source& source, const S& dt_s) {
    const S T = s.kinetics.drive.temperature_K;
    const S begin_K_s = rate_K_s(p, s, source);
    if (begin_K_s == S(0)) {
      return;
    }
    State middle = s;
    Duhem<S>::advance(p.kinetics, middle.kinetics, drive(p, T + S(0.5) * dt_s * begin_K_s));
    const S middle_K_s = rate_K_s(p, middle, source, s.heading);
    Duhem<S>::advance(p.kinetics, s.kinetics, drive(p, T + dt_s * middle_K_s));
  }
};

}  // namespace smaservo::papers
