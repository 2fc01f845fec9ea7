#pragma once
// The parameters of a wire that a fit may change. Each is described once: its name, its prior
// standard deviation, and how the wire is computed from it. Every parameter is a deviation u from
// the wire at the start of the fit, in units of its prior standard deviation, so the prior is u = 0
// ± 1. Values that must be positive stay positive; the narrower limits of a wire file are checked
// when it is written.

#include <algorithm>
#include <cmath>
#include <string>
#include <string_view>
#include <vector>

#include "model/wire/wire.hpp"

namespace smaservo::identify {

/// How a value is computed from its deviation.
enum class Form : unsigned char {
  sum,     ///< value + sd u
  factor,  ///< value exp(sd u)
  share,   ///< between two limits: logit(s) + sd u, with s = (value - least)/(most - least)
};

struct FitParameter {
  std::string key;
  std::string unit;  ///< unit of value and sd in messages; empty for a number
  double scale;      ///< the unit in SI
  Form form;
  double prior;  ///< SI
  /// Standard deviation of the prior, in SI; relative for a factor, in logits for a share.
  double sd;
  double least = 0, most = 1;  ///< SI; the limits of a share

  /// The position of a value between the limits, 0 to 1.
  template <class T>
  T share_of(const T& value) const {
    return (value - T(least)) / T(most - least);
  }

  /// The value for deviation u; for u = 0 the prior, to the last bit.
  template <class T>
  T value(const T& u) const {
    using std::exp;
    switch (form) {
      case Form::sum:
        return T(prior) + T(sd) * u;
      case Form::factor:
        return T(prior) * exp(T(sd) * u);
      case Form::share: {
        const double share = share_of(prior);
        const T odds = exp(T(-sd) * u);
        return T(prior) + T((most - least) * share * (1 - share)) * (T(1) - odds) /
                              (T(share) + T(1 - share) * odds);
      }
    }
    return T(prior);
  }
};

/// Parts of a fit besides the parameters that every wire has.
struct FitVariant {
  bool separate_r2a = false;  ///< R2A has a surface of its own
  bool separate_r2m = false;
  Memory memory = Memory::return_point;
  Mixture mixture = Mixture::series;
  bool circuit = false;  ///< resistance of the leads and gain of the load cell are fitted

  bool operator==(const FitVariant&) const = default;
};

/// Whether the key belongs to a transformation process, such as "wire.m2a.width" or "wire.r2m".
inline bool is_of_process(std::string_view key) {
  constexpr std::string_view processes[] = {"wire.m2a", "wire.a2m", "wire.a2r", "wire.r2a",
                                            "wire.r2m"};
  return std::ranges::any_of(processes, [&](auto process) { return key.starts_with(process); });
}

namespace detail {

// A surface described by values that the data determine independently: the temperature T_t of the
// turning point, where the curve is steepest, and the width T_f - T_s, which is the inverse of its
// slope there. Both ends of the stress range, 0 and the greatest, have their own values, so that a
// surface that is valid at both is valid between them.
template <class T, class Take>
Surface<T> vary_surface(const Surface<double>& from, const std::string& name, double max_Pa,
                        double temperature_sd_K, double stress_share, Take& take) {
  const auto line = [&](const double(&c)[2], double stress) { return c[0] + c[1] * stress; };
  const auto cubic = [&](const double(&c)[3], double stress) {
    return c[0] + stress * (c[1] + stress * c[2]);
  };
  const auto width = [&](double stress) {
    return cubic(from.finish_K, stress) - cubic(from.start_K, stress);
  };
  const auto turning_K = [&](double stress) {
    return cubic(from.start_K, stress) + line(from.turning, stress) * width(stress);
  };
  const double w_0 = width(0);
  const double w_1 = width(max_Pa);
  const double T_0 = turning_K(0);
  const double T_1 = turning_K(max_Pa);
  const double deviation_K = turning_K(max_Pa / 2) - (T_0 + T_1) / 2;
  const double bend_K = std::abs(deviation_K) < 1e-9 ? 0 : deviation_K;  // rounding
  const std::string key = "wire." + name;

  const T at_0 = take({key + ".temperature", "degC", 1, Form::sum, T_0, temperature_sd_K});
  const double rise = (T_1 - T_0) / max_Pa;
  const T slope =
      take({key + ".temperature_stress", "K/MPa", 1e-6, Form::sum, rise, 0.04e-6 * stress_share});
  const T bend = take({key + ".temperature_bend", "K", 1, Form::sum, bend_K, 6 * stress_share});
  const T width_0 = take({key + ".width", "", 1, Form::factor, w_0, 0.5});
  const T width_1 =
      width_0 * T(w_1 / w_0) * take({key + ".width_stress", "", 1, Form::factor, 1, 0.3});
  const auto shape = [&](const std::string& part, const double(&c)[2], double least, double most,
                         double sd, double stress_sd) {
    using std::exp;
    // A prior at a limit could not be moved by any deviation.
    const double margin = 1e-6 * (most - least);
    const auto inner = [&](double x) { return std::clamp(x, least + margin, most - margin); };
    const FitParameter one{key + part, "", 1, Form::share, inner(c[0]), sd, least, most};
    const T first = take(one);
    const T shift = take({key + part + "_stress", "", 1, Form::sum, 0, stress_sd});
    const double begin = one.share_of(one.prior);
    const double end = one.share_of(inner(line(c, max_Pa)));
    const T odds = T(end / (1 - end) * (1 - begin) / begin) * exp(shift);
    const T x = one.share_of(first);
    const T second = T(least) + T(most - least) * x * odds / (T(1) - x + x * odds);
    return std::pair<T, T>(first, second);
  };
  // The limits are those of a wire file. The prior is wide, because wires differ: there are curves
  // with corners (0.1) and with long tails (10).
  const auto [curvature_0, curvature_1] = shape(".curvature", from.curvature, 1e-3, 30, 0.6, 0.3);
  const auto [z_0, z_1] = shape(".turning", from.turning, 0.05, 0.95, 0.5, 0.5);

  const T span = T(max_Pa);
  const T dw = (width_1 - width_0) / span;
  const T dz = (z_1 - z_0) / span;
  // T_t = T_0 + slope σ + 4 bend (σ/σ_1)(1 - σ/σ_1)
  const T quadratic = T(-4) * bend / (span * span);
  const T linear = slope + T(4) * bend / span;
  Surface<T> s;
  s.start_K[0] = at_0 - z_0 * width_0;
  s.start_K[1] = linear - z_0 * dw - dz * width_0;
  s.start_K[2] = quadratic - dz * dw;
  s.finish_K[0] = s.start_K[0] + width_0;
  s.finish_K[1] = s.start_K[1] + dw;
  s.finish_K[2] = s.start_K[2];
  s.curvature[0] = curvature_0;
  s.curvature[1] = (curvature_1 - curvature_0) / span;
  s.turning[0] = z_0;
  s.turning[1] = dz;
  return s;
}

}  // namespace detail

/// The wire whose parameters are given by `take(FitParameter) -> T`, which is called once for each
/// of them, always in the same order.
template <class T, class Take>
Wire<T> vary_wire(const Wire<double>& from, const FitVariant& variant, Take take) {
  Wire<T> w{};
  w.geometry = {T(from.geometry.length_m), T(from.geometry.diameter_m)};
  w.limits = {T(from.limits.current_A), T(from.limits.stress_Pa), T(from.limits.temperature_K)};
  w.nominal_stroke = T(from.nominal_stroke);
  w.accuracy = {T(from.accuracy.strain), T(from.accuracy.resistance)};

  const double max_Pa = from.limits.stress_Pa;
  const ThreePhaseParams<double>& k = from.kinetics;
  const auto surface = [&](const Surface<double>& s, const char* name, double sd_K, double share) {
    return detail::vary_surface<T>(s, name, max_Pa, sd_K, share, take);
  };
  const Surface<double> a2m = first_surface(k.a2m_a2r);
  w.kinetics.m2a = surface(k.m2a, "m2a", 8, 1);
  const Surface<T> a2m_T = surface(a2m, "a2m", 8, 1);
  const Surface<T> a2r_T = surface(second_surface(k.a2m_a2r), "a2r", 6, 0.5);
  w.kinetics.a2m_a2r = pair_surfaces(a2m_T, a2r_T);
  w.kinetics.separate_r2a = variant.separate_r2a;
  w.kinetics.separate_r2m = variant.separate_r2m;
  if (variant.separate_r2a) {
    w.kinetics.r2a = surface(k.separate_r2a ? k.r2a : k.m2a, "r2a", 6, 0.5);
  }
  if (variant.separate_r2m) {
    w.kinetics.r2m = surface(k.separate_r2m ? k.r2m : a2m, "r2m", 6, 0.5);
  }
  w.kinetics.memory = variant.memory;
  w.kinetics.smallest_reversal_K = T(k.smallest_reversal_K);

  const Material<double>& m = from.material;
  w.material.reference_K = T(m.reference_K);
  w.material.mixture = variant.mixture;
  const double rho = m.martensite.resistivity_ohm_m;
  const T rho_M = take({"wire.martensite.resistivity", "uohm m", 1e-6, Form::factor, rho, 0.1});
  const auto phase = [&](const Phase<double>& p, const std::string& name, double strain_sd,
                         double rho_sd) {
    const std::string key = "wire." + name;
    Phase<T> to{};
    to.strain = strain_sd > 0 ? take({key + ".strain", "%", 0.01, Form::sum, p.strain, strain_sd})
                              : T(p.strain);
    to.modulus_Pa = take({key + ".modulus", "GPa", 1e9, Form::factor, p.modulus_Pa, 0.4});
    const double own = p.resistivity_ohm_m;
    to.resistivity_ohm_m =
        rho_sd > 0
            ? rho_M * take({key + ".resistivity_ratio", "", 1, Form::factor, own / rho, rho_sd})
            : rho_M;
    const double slope = p.resistivity_ohm_m_K / own;
    to.resistivity_ohm_m_K = to.resistivity_ohm_m * take({key + ".resistivity_temperature", "1/K",
                                                          1, Form::sum, slope, 2e-4});
    const double by_stress = p.resistivity_ohm_m_Pa / own;
    // q_M = 0 (000, 'Stress dependence of the material parameters')
    to.resistivity_ohm_m_Pa =
        to.resistivity_ohm_m *
        (rho_sd > 0
             ? take({key + ".resistivity_stress", "1/GPa", 1e-9, Form::sum, by_stress, 0.1e-9})
             : T(by_stress));
    return to;
  };
  w.material.martensite = phase(m.martensite, "martensite", 0.008, 0);
  w.material.r_phase = phase(m.r_phase, "r_phase", 0.003, 0.04);
  w.material.austenite = phase(m.austenite, "austenite", 0, 0.06);

  const HeatParams<double>& h = from.heat;
  w.heat.density_kg_m3 = T(h.density_kg_m3);
  w.heat.specific_heat_J_kgK =
      take({"wire.heat.specific_heat", "J/kgK", 1, Form::factor, h.specific_heat_J_kgK, 0.12});
  w.heat.latent_m2a_J_kg =
      take({"wire.heat.latent_m2a", "kJ/kg", 1e3, Form::factor, h.latent_m2a_J_kg, 0.25});
  // R2M has the difference, so this latent heat cannot exceed that of M2A.
  const double part = h.latent_m2a_J_kg > 0 ? h.latent_r2a_J_kg / h.latent_m2a_J_kg : 0;
  w.heat.latent_r2a_J_kg =
      w.heat.latent_m2a_J_kg * take({"wire.heat.latent_r2a_share", "", 1, Form::share, part, 0.4});
  w.heat.convection_W_m2K =
      take({"wire.heat.convection", "W/m2K", 1, Form::factor, h.convection_W_m2K, 0.3});
  w.heat.convection_W_m2K2 =
      take({"wire.heat.convection_slope", "W/m2K2", 1, Form::factor, h.convection_W_m2K2, 0.5});
  w.heat.clamp_conductivity_W_mK = take(
      {"wire.heat.clamp_conductivity", "W/mK", 1, Form::factor, h.clamp_conductivity_W_mK, 0.3});
  return w;
}

/// All parameters of a variant, in their order.
inline std::vector<FitParameter> fit_parameters(const Wire<double>& from,
                                                const FitVariant& variant) {
  std::vector<FitParameter> all;
  vary_wire<double>(from, variant, [&](const FitParameter& parameter) {
    all.push_back(parameter);
    return parameter.value(0.0);
  });
  return all;
}

}  // namespace smaservo::identify
