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
#include <utility>
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
  /// That surface is sought near A2R's, not where the wire at the start of the fit has R2A.
  bool r2a_near_a2r = false;
  bool separate_r2m = false;
  Memory memory = Memory::return_point;
  bool taper = false;       ///< the ends of the curves are fitted
  bool loop_order = false;  ///< the odds of the inner loops are fitted
  Mixture mixture = Mixture::series;
  bool circuit = false;           ///< resistance of the leads and gain of the load cell are fitted
  bool wire_temperature = false;  ///< some run knows the temperature of the wire itself

  bool operator==(const FitVariant&) const = default;
};

/// Whether the key belongs to a transformation process, such as "wire.m2a.width" or "wire.r2m".
inline bool is_of_process(std::string_view key) {
  constexpr std::string_view processes[] = {"wire.m2a", "wire.a2m", "wire.a2r", "wire.r2a",
                                            "wire.r2m"};
  return std::ranges::any_of(processes, [&](auto process) { return key.starts_with(process); });
}

/// The surface of an R-phase that becomes austenite `hysteresis_K` above where it came from
/// austenite. What came last goes first.
inline Surface<double> r2a_above(const Surface<double>& a2r, double hysteresis_K) {
  Surface<double> r2a = a2r;
  std::swap(r2a.start_K, r2a.finish_K);
  r2a.start_K[0] += hysteresis_K;
  r2a.finish_K[0] += hysteresis_K;
  r2a.turning[0] = 1 - a2r.turning[0];
  r2a.turning[1] = -a2r.turning[1];
  return r2a;
}

/// Where a fit of the ends and of the order of the loops starts, if the wire has those of paper
/// 000: from there the cost has no derivative by them.
inline ThreePhaseParams<double> ordered_before(ThreePhaseParams<double> from, Memory memory) {
  constexpr double taper = 0.1, odds = 2;
  const auto start = [](double& of) { of = of > 0 ? of : taper; };
  Surface<double> a2m = first_surface(from.a2m_a2r);
  Surface<double> a2r = second_surface(from.a2m_a2r);
  for (Surface<double>* surface : {&from.m2a, &a2m, &a2r, &from.r2a, &from.r2m}) {
    start(surface->taper);
  }
  from.a2m_a2r = pair_surfaces(a2m, a2r);
  const bool is_paper = !(std::abs(from.loop_odds - 1) > 0);
  from.loop_odds = is_paper && memory == Memory::return_point ? odds : from.loop_odds;
  return from;
}

namespace detail {

/// The values of a surface that the data determine independently: the temperature T_t of the
/// turning point, where the curve is steepest, and the width T_f - T_s, which is the inverse of its
/// slope there. Both ends of the stress range, 0 and the greatest, have their own values, so that a
/// surface that is valid at both is valid between them.
template <class T>
struct SurfaceEnds {
  T turning_K, slope_K_Pa, bend_K;  ///< T_t at no stress, and how it depends on stress
  T taper;
  T width_K[2], curvature[2], turning[2];  ///< at no stress, and at the greatest

  /// T_t = T_0 + slope σ + 4 bend (σ/σ_1)(1 - σ/σ_1)
  Surface<T> surface(const T& max_Pa) const {
    const T dw = (width_K[1] - width_K[0]) / max_Pa;
    const T dz = (turning[1] - turning[0]) / max_Pa;
    const T quadratic = T(-4) * bend_K / (max_Pa * max_Pa);
    const T linear = slope_K_Pa + T(4) * bend_K / max_Pa;
    Surface<T> s;
    s.start_K[0] = turning_K - turning[0] * width_K[0];
    s.start_K[1] = linear - turning[0] * dw - dz * width_K[0];
    s.start_K[2] = quadratic - dz * dw;
    s.finish_K[0] = s.start_K[0] + width_K[0];
    s.finish_K[1] = s.start_K[1] + dw;
    s.finish_K[2] = s.start_K[2];
    s.curvature[0] = curvature[0];
    s.curvature[1] = (curvature[1] - curvature[0]) / max_Pa;
    s.turning[0] = turning[0];
    s.turning[1] = dz;
    s.taper = taper;
    return s;
  }
};

/// Value c_0 + c_1 σ of a number between two limits, at no stress and at the greatest: a share at
/// no stress, and how far its logit moves from there.
template <class T, class Take>
void vary_shape(const std::string& key, const FitParameter& share, const double (&c)[2],
                double max_Pa, double stress_sd, Take& take, T (&ends)[2]) {
  using std::exp;
  // A prior at a limit could not be moved by any deviation.
  const double margin = 1e-6 * (share.most - share.least);
  const auto inner = [&](double x) {
    return std::clamp(x, share.least + margin, share.most - margin);
  };
  FitParameter first = share;
  first.key = key;
  first.prior = inner(c[0]);
  ends[0] = take(first);
  const T shift = take({key + "_stress", "", 1, Form::sum, 0, stress_sd});
  const double begin = first.share_of(first.prior);
  const double end = first.share_of(inner(c[0] + c[1] * max_Pa));
  const T odds = T(end / (1 - end) * (1 - begin) / begin) * exp(shift);
  const T x = first.share_of(ends[0]);
  ends[1] = T(share.least) + T(share.most - share.least) * x * odds / (T(1) - x + x * odds);
}

/// A number within a range. A prior at an end of it could not be moved by any deviation.
inline FitParameter share_of_range(std::string key, double prior, double least, double most) {
  const double margin = 1e-6 * (most - least);
  return {
      std::move(key), "",  1, Form::share, std::clamp(prior, least + margin, most - margin), 1.5,
      least,          most};
}

template <class T, class Take>
Surface<T> vary_surface(const Surface<double>& from, const std::string& name, double max_Pa,
                        double temperature_sd_K, double stress_share, bool taper, Take& take) {
  const auto cubic = [&](const double(&c)[3], double stress) {
    return c[0] + stress * (c[1] + stress * c[2]);
  };
  const auto width = [&](double stress) {
    return cubic(from.finish_K, stress) - cubic(from.start_K, stress);
  };
  const auto turning_K = [&](double stress) {
    const double z = from.turning[0] + from.turning[1] * stress;
    return cubic(from.start_K, stress) + z * width(stress);
  };
  const double w_0 = width(0);
  const double w_1 = width(max_Pa);
  const double T_0 = turning_K(0);
  const double T_1 = turning_K(max_Pa);
  const double deviation_K = turning_K(max_Pa / 2) - (T_0 + T_1) / 2;
  const double bend_K = std::abs(deviation_K) < 1e-9 ? 0 : deviation_K;  // rounding
  const double rise = (T_1 - T_0) / max_Pa;
  const std::string key = "wire." + name;

  SurfaceEnds<T> to;
  to.turning_K = take({key + ".temperature", "degC", 1, Form::sum, T_0, temperature_sd_K});
  to.slope_K_Pa =
      take({key + ".temperature_stress", "K/MPa", 1e-6, Form::sum, rise, 0.04e-6 * stress_share});
  to.bend_K = take({key + ".temperature_bend", "K", 1, Form::sum, bend_K, 6 * stress_share});
  to.width_K[0] = take({key + ".width", "", 1, Form::factor, w_0, 0.5});
  to.width_K[1] =
      to.width_K[0] * T(w_1 / w_0) * take({key + ".width_stress", "", 1, Form::factor, 1, 0.3});
  // The limits are those of a wire file. The prior is wide, because wires differ: there are curves
  // with corners (0.1) and with long tails (10).
  const FitParameter curvature{"", "", 1, Form::share, 0, 0.6, 1e-3, 30};
  const FitParameter turning{"", "", 1, Form::share, 0, 0.5, 0.05, 0.95};
  vary_shape<T>(key + ".curvature", curvature, from.curvature, max_Pa, 0.3, take, to.curvature);
  vary_shape<T>(key + ".turning", turning, from.turning, max_Pa, 0.5, take, to.turning);
  to.taper = taper ? take(share_of_range(key + ".taper", from.taper, 0, surface_range.max_taper))
                   : T(from.taper);
  return to.surface(T(max_Pa));
}

/// The surface of R2A before the fit. The R-phase of NiTi has a hysteresis of 2 to 6 K
/// (literature).
inline Surface<double> r2a_before(const ThreePhaseParams<double>& from, const FitVariant& variant) {
  return variant.r2a_near_a2r ? r2a_above(second_surface(from.a2m_a2r), 4)
         : from.separate_r2a  ? from.r2a
                              : from.m2a;
}

template <class T, class Take>
ThreePhaseParams<T> vary_kinetics(const ThreePhaseParams<double>& from, double max_Pa,
                                  const FitVariant& variant, Take& take) {
  const auto surface = [&](const Surface<double>& s, const char* name, double sd_K, double share) {
    return vary_surface<T>(s, name, max_Pa, sd_K, share, variant.taper, take);
  };
  ThreePhaseParams<T> to{};
  const Surface<double> a2m = first_surface(from.a2m_a2r);
  to.m2a = surface(from.m2a, "m2a", 8, 1);
  const Surface<T> a2m_T = surface(a2m, "a2m", 8, 1);
  const Surface<T> a2r_T = surface(second_surface(from.a2m_a2r), "a2r", 6, 0.5);
  to.a2m_a2r = pair_surfaces(a2m_T, a2r_T);
  to.separate_r2a = variant.separate_r2a;
  to.separate_r2m = variant.separate_r2m;
  if (variant.separate_r2a) {
    to.r2a = surface(r2a_before(from, variant), "r2a", 6, 0.5);
  }
  if (variant.separate_r2m) {
    to.r2m = surface(from.separate_r2m ? from.r2m : a2m, "r2m", 6, 0.5);
  }
  to.memory = variant.memory;
  to.smallest_reversal_K = T(from.smallest_reversal_K);
  to.loop_odds = variant.loop_order ? take(share_of_range("wire.loops.odds", from.loop_odds,
                                                          loop_odds_range.min, loop_odds_range.max))
                                    : T(from.loop_odds);
  return to;
}

/// The standard deviations of a phase's parameters. 0: the parameter is not fitted, the resistivity
/// is martensite's and does not depend on stress otherwise than the wire's at the start.
struct PhaseSd {
  double strain, resistivity_ratio;
};

/// The resistivity is a ratio of martensite's, `rho_M` now and `rho_ohm_m` at the start.
template <class T, class Take>
Phase<T> vary_phase(const Phase<double>& from, const std::string& name, const PhaseSd& sd,
                    const T& rho_M, double rho_ohm_m, Take& take) {
  const std::string key = "wire." + name;
  const bool own = sd.resistivity_ratio > 0;
  const double ratio = from.resistivity_ohm_m / rho_ohm_m;
  const double by_K = from.resistivity_ohm_m_K / from.resistivity_ohm_m;
  const double by_Pa = from.resistivity_ohm_m_Pa / from.resistivity_ohm_m;
  Phase<T> to{};
  to.strain = sd.strain > 0 ? take({key + ".strain", "%", 0.01, Form::sum, from.strain, sd.strain})
                            : T(from.strain);
  to.modulus_Pa = take({key + ".modulus", "GPa", 1e9, Form::factor, from.modulus_Pa, 0.4});
  to.resistivity_ohm_m = own ? rho_M * take({key + ".resistivity_ratio", "", 1, Form::factor, ratio,
                                             sd.resistivity_ratio})
                             : rho_M;
  to.resistivity_ohm_m_K = to.resistivity_ohm_m * take({key + ".resistivity_temperature", "1/K", 1,
                                                        Form::sum, by_K, 2e-4});
  // q_M = 0 (000, 'Stress dependence of the material parameters')
  to.resistivity_ohm_m_Pa =
      to.resistivity_ohm_m *
      (own ? take({key + ".resistivity_stress", "1/GPa", 1e-9, Form::sum, by_Pa, 0.1e-9})
           : T(by_Pa));
  return to;
}

template <class T, class Take>
Material<T> vary_material(const Material<double>& from, const FitVariant& variant, Take& take) {
  Material<T> to{};
  to.reference_K = T(from.reference_K);
  to.mixture = variant.mixture;
  const double rho = from.martensite.resistivity_ohm_m;
  const T rho_M = take({"wire.martensite.resistivity", "uohm m", 1e-6, Form::factor, rho, 0.1});
  const auto phase = [&](const Phase<double>& p, const char* name, const PhaseSd& sd) {
    return vary_phase<T>(p, name, sd, rho_M, rho, take);
  };
  to.martensite = phase(from.martensite, "martensite", {0.008, 0});
  to.r_phase = phase(from.r_phase, "r_phase", {0.003, 0.04});
  to.austenite = phase(from.austenite, "austenite", {0, 0.06});
  return to;
}

template <class T, class Take>
HeatParams<T> vary_heat(const HeatParams<double>& from, const FitVariant& variant, Take& take) {
  const auto factor = [&](const char* key, const char* unit, double scale, double prior,
                          double sd) {
    return take({std::string("wire.heat.") + key, unit, scale, Form::factor, prior, sd});
  };
  HeatParams<T> to{};
  to.density_kg_m3 = T(from.density_kg_m3);
  // Literature: 400 to 500 J/kgK. Where no run knows the wire's temperature, this prior decides how
  // hot the fit takes the wire for: README.md, "How hot the wire is".
  to.specific_heat_J_kgK = factor("specific_heat", "J/kgK", 1, from.specific_heat_J_kgK,
                                  variant.wire_temperature ? 0.12 : 0.05);
  to.latent_m2a_J_kg = factor("latent_m2a", "kJ/kg", 1e3, from.latent_m2a_J_kg, 0.25);
  // R2M has the difference, so this latent heat cannot exceed that of M2A.
  const double part = from.latent_m2a_J_kg > 0 ? from.latent_r2a_J_kg / from.latent_m2a_J_kg : 0;
  to.latent_r2a_J_kg =
      to.latent_m2a_J_kg * take({"wire.heat.latent_r2a_share", "", 1, Form::share, part, 0.4});
  to.convection_W_m2K = factor("convection", "W/m2K", 1, from.convection_W_m2K, 0.3);
  to.convection_W_m2K2 = factor("convection_slope", "W/m2K2", 1, from.convection_W_m2K2, 0.5);
  // The alloy's own is known better; but with a convection it stands for the length of the cold
  // ends (cold_ends()), which the model knows only roughly.
  to.clamp_conductivity_W_mK =
      factor("clamp_conductivity", "W/mK", 1, from.clamp_conductivity_W_mK, 0.6);
  return to;
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
  w.kinetics = detail::vary_kinetics<T>(from.kinetics, from.limits.stress_Pa, variant, take);
  w.material = detail::vary_material<T>(from.material, variant, take);
  w.heat = detail::vary_heat<T>(from.heat, variant, take);
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
