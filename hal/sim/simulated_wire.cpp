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
/// in the middle.
template <class Plant, std::size_t segments>
typename Plant::Params distribute(const Wire<double>& wire) {
  typename Plant::Params p{};
  p.material = wire.material;
  p.heat = wire.heat;
  p.geometry = wire.geometry;
  double sum = 0;
  for (std::size_t i = 0; i < segments; ++i) {
    p.length_m[i] = std::pow(1.5, std::min(i, segments - 1 - i));
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

}  // namespace

std::string_view family_name(Family family) {
  constexpr std::array<std::string_view, families.size()> names{"ihyp", "sublayers", "free-energy"};
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

std::unique_ptr<SimulatedWire> make_simulated_wire(Family family, const Wire<double>& wire,
                                                   const Structure& structure, double scatter_K,
                                                   std::mt19937_64& random) {
  switch (family) {
    case Family::ihyp:
      return make_ihyp(wire, scatter_K, random);
    case Family::sublayers:
      return make_sublayers(wire, structure.sublayers, scatter_K, random);
    case Family::free_energy:
      break;
  }
  return make_free_energy(wire, structure.free_energy, scatter_K, random);
}

}  // namespace smaservo::hal
