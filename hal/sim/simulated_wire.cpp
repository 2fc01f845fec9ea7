#include "hal/sim/simulated_wire.hpp"

#include <algorithm>
#include <cmath>

#include "model/wire/distributed.hpp"

namespace smaservo::hal {
namespace {

/// The temperature at which a process has converted this fraction.
double temperature_K(const Surface<double>& surface, double converted, double stress_Pa) {
  const Isobar<double> at = isobar(surface, stress_Pa);
  return at.start_K + ihyp_temperature(at.shape, {converted, 1 - converted}) / at.per_K;
}

ThresholdSpread spread(const Surface<double>& surface) {
  const double median_K = temperature_K(surface, 0.5, 0);
  const double a_K = temperature_K(surface, 0.2, 0);
  const double b_K = temperature_K(surface, 0.8, 0);
  const double per_K = 1 / std::log(4.0);  // logistic: the quantile at 80 % is ln 4 scales away
  // The parabola through the medians at 0, 200 and 400 MPa.
  const double step_Pa = 200e6;
  const double one_K = temperature_K(surface, 0.5, step_Pa) - median_K;
  const double two_K = temperature_K(surface, 0.5, 2 * step_Pa) - median_K;
  return {median_K, (median_K - std::min(a_K, b_K)) * per_K,
          (std::max(a_K, b_K) - median_K) * per_K, (2 * one_K - 0.5 * two_K) / step_Pa,
          (0.5 * two_K - one_K) / (step_Pa * step_Pa)};
}

/// Makes short segments at the clamps, where the temperature changes along the wire, and long ones
/// in the middle: `equal` short ones, and then each so many times as long as the one before.
template <class Plant, std::size_t segments>
typename Plant::Params distribute(const Wire<double>& wire, std::size_t equal = 1,
                                  double growth = 1.5) {
  typename Plant::Params p{};
  p.material = wire.material;
  p.heat = wire.heat;
  p.geometry = wire.geometry;
  double sum = 0;
  for (std::size_t i = 0; i < segments; ++i) {
    const std::size_t from_clamp = std::min(i, segments - 1 - i);
    p.length_m[i] = std::pow(growth, std::max(from_clamp, equal - 1) - (equal - 1));
    sum += p.length_m[i];
  }
  for (double& length_m : p.length_m) {
    length_m *= wire.geometry.length_m / sum;
  }
  return p;
}

template <class K, std::size_t segments>
class DistributedWire : public SimulatedWire {
 public:
  using Plant = DistributedPlant<K, segments>;

  explicit DistributedWire(const typename Plant::Params& params) : params_(params) {
    rest(room_K, 0);
  }

  void rest(double temperature_K, double stress_Pa) final {
    state_ = Plant::rest(params_, {temperature_K, stress_Pa});
  }
  void soak(double temperature_K, double stress_Pa) final {
    Plant::soak(params_, state_, {temperature_K, stress_Pa});
  }
  void advance(double current_A, const Surroundings& around, double dt_s) final {
    Plant::advance(params_, state_, current_A, {around.stress_Pa, around.ambient_K}, around.draught,
                   dt_s);
  }
  double strain_after(double current_A, const Surroundings& around, double dt_s) const final {
    typename Plant::State trial = state_;
    Plant::advance(params_, trial, current_A, {around.stress_Pa, around.ambient_K}, around.draught,
                   dt_s);
    return Plant::strain(params_, trial);
  }

  double strain() const final { return Plant::strain(params_, state_); }
  double resistance_ohm() const final { return Plant::resistance_ohm(params_, state_); }
  double hottest_K() const final {
    double hottest = Plant::temperature_K(state_, 0);
    for (std::size_t i = 1; i < segments; ++i) {
      hottest = std::max(hottest, Plant::temperature_K(state_, i));
    }
    return hottest;
  }
  double average_K() const final {
    return average([&](std::size_t i) { return Plant::temperature_K(state_, i); });
  }
  Phases<double> phases() const final {
    return {average([&](std::size_t i) { return state_.profile.martensite[i]; }),
            average([&](std::size_t i) { return state_.profile.r_phase[i]; })};
  }

 private:
  template <class F>
  double average(F of) const {
    double sum = 0;
    for (std::size_t i = 0; i < segments; ++i) {
      sum += of(i) * params_.length_m[i];
    }
    return sum / params_.geometry.length_m;
  }

  typename Plant::Params params_;
  typename Plant::State state_{};
};

std::unique_ptr<SimulatedWire> make_ihyp(const Wire<double>& wire, double scatter_K,
                                         std::mt19937_64& random) {
  // A memory of 24 loops is enough for the tiny loops that the load's noise makes within large
  // ones.
  using K = ThreePhase<double, 24>;
  constexpr std::size_t segments = 24;
  auto p = distribute<DistributedPlant<K, segments>, segments>(wire);
  std::normal_distribution<double> normal;
  for (K::Params& k : p.kinetics) {
    const double warmer_K = scatter_K * normal(random);
    k = wire.kinetics;
    k.smallest_reversal_K = 0;
    const auto shift = [](auto& surface, auto by) {
      surface.start_K[0] += by;
      surface.finish_K[0] += by;
    };
    shift(k.m2a, warmer_K);
    shift(k.a2m_a2r, Pair<double>(warmer_K));
    shift(k.r2a, warmer_K);
    shift(k.r2m, warmer_K);
  }
  return std::make_unique<DistributedWire<K, segments>>(p);
}

/// The spread with all thresholds shifted by by_K.
template <class Spread>
Spread warmer(Spread spread, double by_K) {
  for (ThresholdSpread* process : {&spread.m2a, &spread.a2m, &spread.r2a, &spread.a2r}) {
    process->median_K += by_K;
  }
  return spread;
}

std::unique_ptr<SimulatedWire> make_sublayers(const Wire<double>& wire,
                                              const SublayerStructure& structure, double scatter_K,
                                              std::mt19937_64& random) {
  using K = Sublayers<double>;
  constexpr std::size_t segments = 12;
  auto p = distribute<DistributedPlant<K, segments>, segments>(wire);
  p.specific_heat_1_K = structure.specific_heat_1_K;
  p.parallel_share = structure.parallel_share;
  std::normal_distribution<double> normal;
  SublayerSpread spread = sublayer_spread(wire, structure);
  for (K::Params& k : p.kinetics) {
    k = K::params(warmer(spread, scatter_K * normal(random)));
    ++spread.seed;
  }
  return std::make_unique<DistributedWire<K, segments>>(p);
}

std::unique_ptr<SimulatedWire> make_free_energy(const Wire<double>& wire,
                                                const FreeEnergyStructure& structure,
                                                double scatter_K, std::mt19937_64& random) {
  using K = FreeEnergy<double>;
  constexpr std::size_t segments = 12;
  auto p = distribute<DistributedPlant<K, segments>, segments>(wire);
  p.specific_heat_1_K = structure.specific_heat_1_K;
  p.parallel_share = 1;
  std::normal_distribution<double> normal;
  const FreeEnergySpread spread = free_energy_spread(wire, structure);
  for (K::Params& k : p.kinetics) {
    k = K::params(warmer(spread, scatter_K * normal(random)));
  }
  return std::make_unique<DistributedWire<K, segments>>(p);
}

std::unique_ptr<SimulatedWire> make_smooth_hardening(const Wire<double>& wire,
                                                     const SmoothHardeningStructure& structure,
                                                     double scatter_K, std::mt19937_64& random) {
  using K = SmoothHardening<double>;
  constexpr std::size_t segments = 24;
  // Of 0.1 m the ends' 2.3 mm are divided into 0.38 mm, a third of what the cold of a clamp
  // reaches into 76 um.
  auto p = distribute<DistributedPlant<K, segments>, segments>(wire, 6, 2);
  p.heat.clamp_conductivity_W_mK *= structure.conduction;
  p.clamp_resistance_m = structure.clamp_resistance_m;
  p.specific_heat_1_K = structure.specific_heat_1_K;
  p.parallel_share = structure.parallel_share;
  p.strain_deficit = structure.strain_deficit;
  p.strain_saturation_Pa = structure.saturation_Pa;
  std::normal_distribution<double> normal;
  const SmoothHardeningNumbers numbers = smooth_hardening_numbers(wire, structure);
  for (K::Params& k : p.kinetics) {
    k = K::params(numbers);
    const double warmer_K = scatter_K * normal(random);
    for (SmoothTransformation<double>* process : {&k.m2a, &k.a2m, &k.r2a, &k.a2r}) {
      process->from_K += warmer_K;
      process->to_K += warmer_K;
    }
  }
  return std::make_unique<DistributedWire<K, segments>>(p);
}

/// The transformation with these exponents that goes through two temperatures without stress.
SmoothTransformation<double> through(double converted, double at_K, double later_K_from_20_to_80,
                                     double first, double last) {
  SmoothTransformation<double> t{0, 1, first, last, 0, 0};
  const double range_K = later_K_from_20_to_80 / (t.at_K(0.8) - t.at_K(0.2));
  t.from_K = at_K - range_K * t.at_K(converted);
  t.to_K = t.from_K + range_K;
  return t;
}

/// The distance from 20 to 80 %; negative where cooling transforms.
double width_K(const Surface<double>& surface) {
  return temperature_K(surface, 0.8, 0) - temperature_K(surface, 0.2, 0);
}

/// How much higher the first curve lies than the second at equal fractions, at least, without
/// stress and at the stress.
double least_gap_K(const SmoothTransformation<double>& heating,
                   const SmoothTransformation<double>& cooling, double strained_Pa,
                   double stress_Pa) {
  const double shift_K = (heating.per_Pa - cooling.per_Pa) * strained_Pa +
                         (heating.per_Pa2 - cooling.per_Pa2) * stress_Pa * stress_Pa;
  double least_K = heating.at_K(1) - cooling.at_K(0);
  for (const double x : {0.0, 0.1, 0.3, 0.5, 0.7, 0.9}) {
    least_K = std::min(least_K, heating.at_K(x) - cooling.at_K(1 - x));
  }
  return least_K + std::min(shift_K, 0.0);
}

}  // namespace

std::string_view family_name(Family family) {
  constexpr std::array<std::string_view, families.size()> names{"ihyp", "sublayers", "free-energy",
                                                                "smooth-hardening"};
  return names.at(static_cast<std::size_t>(family));
}

SublayerSpread sublayer_spread(const Wire<double>& wire, const SublayerStructure& structure) {
  const ThreePhaseParams<double>& k = wire.kinetics;
  SublayerSpread s{spread(k.m2a),
                   spread(first_surface(k.a2m_a2r)),
                   spread(k.separate_r2a ? k.r2a : k.m2a),
                   spread(second_surface(k.a2m_a2r)),
                   structure.m_correlation,
                   structure.r_correlation,
                   structure.ramp_K,
                   structure.seed};
  s.a2m.below_K *= structure.a2m_tail;
  s.a2r.below_K *= structure.a2r_width;
  s.a2r.above_K *= structure.a2r_width;
  if (!k.separate_r2a) {
    s.r2a.median_K -= structure.r2a_lead_K;
  }
  // At any stress R-phase must transform before martensite does.
  s.r2a.per_Pa = std::min(s.r2a.per_Pa, s.m2a.per_Pa);
  s.r2a.per_Pa2 = std::min(s.r2a.per_Pa2, s.m2a.per_Pa2);
  // bend = 4 t (1 - t) with t = σ/400 MPa
  const double full_Pa = 400e6;
  s.a2m.per_Pa += 4 * structure.bend_K / full_Pa;
  s.a2m.per_Pa2 -= 4 * structure.bend_K / (full_Pa * full_Pa);
  s.a2r.per_Pa += 1e-6 * structure.a2r_K_MPa;
  // A layer is half converted in the middle of its ramp.
  s.m2a.median_K -= 0.5 * structure.ramp_K;
  s.r2a.median_K -= 0.5 * structure.ramp_K;
  s.a2m.median_K += 0.5 * structure.ramp_K;
  s.a2r.median_K += 0.5 * structure.ramp_K;
  return s;
}

FreeEnergySpread free_energy_spread(const Wire<double>& wire,
                                    const FreeEnergyStructure& structure) {
  const ThreePhaseParams<double>& k = wire.kinetics;
  FreeEnergySpread s{spread(k.m2a),
                     spread(first_surface(k.a2m_a2r)),
                     {},
                     spread(second_surface(k.a2m_a2r)),
                     structure.r_correlation,
                     structure.width_K,
                     structure.attempt_s,
                     structure.coupling_K};
  s.a2r.below_K *= structure.a2r_width;
  s.a2r.above_K *= structure.a2r_width;
  s.r2a = s.a2r;
  s.r2a.median_K += structure.r_hysteresis_K;
  return s;
}

SmoothHardeningNumbers smooth_hardening_numbers(const Wire<double>& wire,
                                                const SmoothHardeningStructure& structure) {
  const ThreePhaseParams<double>& k = wire.kinetics;
  const Phase<double>& martensite = wire.material.martensite;
  const Phase<double>& r_phase = wire.material.r_phase;
  const Phase<double>& austenite = wire.material.austenite;
  const double full_Pa = 400e6;
  const double missing_Pa = structure.strain_deficit * structure.saturation_Pa;
  const auto strained_Pa = [&](double stress_Pa) {
    return stress_Pa - missing_Pa * (1 - std::exp(-stress_Pa / structure.saturation_Pa));
  };
  // The work of the stress on the transformation, per volume: H_sat times strained_Pa, and the
  // compliances' difference times σ². It must be some.
  const double strain = std::max(martensite.strain - austenite.strain, 1e-3);
  const double softer_1_Pa =
      std::max(0.5 * (1 / martensite.modulus_Pa - 1 / austenite.modulus_Pa), 0.0);
  const double work_J_m3 = strain * strained_Pa(full_Pa) + softer_1_Pa * full_Pa * full_Pa;
  const auto martensitic = [&](const Surface<double>& surface, double first, double last) {
    const double median_K = temperature_K(surface, 0.5, 0);
    auto t = through(0.5, median_K, width_K(surface), first, last);
    const double per_J_m3 = (temperature_K(surface, 0.5, full_Pa) - median_K) / work_J_m3;
    t.per_Pa = per_J_m3 * strain;
    t.per_Pa2 = per_J_m3 * softer_1_Pa;
    return t;
  };
  SmoothHardeningNumbers n{
      martensitic(k.m2a, structure.m2a_first, structure.m2a_last),
      martensitic(first_surface(k.a2m_a2r), structure.a2m_first, structure.a2m_last),
      {},
      {},
      structure.strain_deficit,
      structure.saturation_Pa};
  // At equal fractions A2M must stay below M2A, whatever the wire's surfaces do.
  const double most_Pa = std::max(wire.limits.stress_Pa, full_Pa);
  const double too_warm_K =
      std::max(0.0, 2 - least_gap_K(n.m2a, n.a2m, strained_Pa(most_Pa), most_Pa));
  n.a2m.from_K -= too_warm_K;
  n.a2m.to_K -= too_warm_K;

  const Surface<double> a2r = second_surface(k.a2m_a2r);
  n.a2r = through(0.2, temperature_K(a2r, 0.2, 0), structure.a2r_width * width_K(a2r),
                  structure.a2r_first, structure.a2r_last);
  // dT/dσ = T Δε/(ρ ΔH)
  const double latent_J_m3 = wire.heat.density_kg_m3 * wire.heat.latent_r2a_J_kg;
  if (0 < latent_J_m3) {
    const double per_J_m3 = temperature_K(a2r, 0.5, 0) / latent_J_m3;
    n.a2r.per_Pa = per_J_m3 * (r_phase.strain - austenite.strain);
    n.a2r.per_Pa2 = per_J_m3 * 0.5 * (1 / r_phase.modulus_Pa - 1 / austenite.modulus_Pa);
  }
  // R2A ends at most 5 K after M2A begins, so that martensite becomes little R-phase on heating.
  const double late_K = std::max(0.0, n.a2r.from_K + structure.r_hysteresis_K - n.m2a.from_K - 5);
  n.a2r.from_K -= late_K;
  n.a2r.to_K -= late_K;
  n.r2a = n.a2r;
  n.r2a.from_K = n.a2r.to_K + structure.r_hysteresis_K;
  n.r2a.to_K = n.a2r.from_K + structure.r_hysteresis_K;
  n.r2a.first = n.a2r.last;
  n.r2a.last = n.a2r.first;
  return n;
}

std::unique_ptr<SimulatedWire> make_simulated_wire(Family family, const Wire<double>& wire,
                                                   const Structure& structure, double scatter_K,
                                                   std::mt19937_64& random) {
  switch (family) {
    case Family::ihyp:
      return make_ihyp(wire, scatter_K, random);
    case Family::sublayers:
      return make_sublayers(wire, structure.sublayers, scatter_K, random);
    case Family::free_energy:
      return make_free_energy(wire, structure.free_energy, scatter_K, random);
    case Family::smooth_hardening:
      break;
  }
  return make_smooth_hardening(wire, structure.smooth_hardening, scatter_K, random);
}

}  // namespace smaservo::hal
