#include "firmware/bench/scenario/units.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <string>

#include "firmware/bench/dice.hpp"

namespace smaservo::bench {
namespace {

Surface<double> vary(Surface<double> surface, double shift_sd_K, Dice& dice) {
  const double shift_K = dice.deviation(shift_sd_K);
  const double slope = dice.factor(0.04);
  const double curvature = dice.factor(0.10);
  for (auto* temperature_K : {&surface.start_K, &surface.finish_K}) {
    (*temperature_K)[0] += shift_K;
    (*temperature_K)[1] *= slope;
    (*temperature_K)[2] *= slope;
  }
  for (double& coefficient : surface.curvature) {
    coefficient *= curvature;
  }
  return surface;
}

void vary(Phase<double>& phase, Dice& dice) {
  phase.strain *= dice.factor(0.03);
  phase.modulus_Pa *= dice.factor(0.08);
  const double resistivity = dice.factor(0.01);
  phase.resistivity_ohm_m *= resistivity;
  phase.resistivity_ohm_m_Pa *= resistivity;
  phase.resistivity_ohm_m_K *= resistivity * dice.factor(0.10);
}

hal::SublayerStructure random_structure(Dice& dice) {
  return {.m_correlation = dice.uniform(0.4, 0.8),
          .r_correlation = dice.uniform(-0.8, -0.4),
          .a2m_tail = dice.uniform(1.1, 1.5),
          .a2r_width = dice.uniform(1.6, 2.4),
          .ramp_K = dice.uniform(1.2, 1.8),
          .r2a_lead_K = dice.uniform(2, 5),
          .bend_K = dice.uniform(0, 2),
          .a2r_K_MPa = dice.uniform(0, 0.02),
          .parallel_share = dice.uniform(0.3, 0.7),
          .specific_heat_1_K = dice.uniform(0.5e-3, 1.5e-3),
          .seed = dice.seed()};
}

hal::FreeEnergyStructure random_barriers(Dice& dice) {
  return {.r_correlation = dice.uniform(-0.8, 0),
          .width_K = dice.uniform(1, 2),
          .attempt_s = dice.uniform(0.5e-3, 2e-3),
          .coupling_K = dice.uniform(2, 6),
          .a2r_width = dice.uniform(1.6, 2.4),
          .r_hysteresis_K = dice.uniform(2, 6),
          .specific_heat_1_K = dice.uniform(0, 1e-3)};
}

hal::SmoothHardeningStructure random_hardening(Dice& dice) {
  return {.m2a_first = dice.uniform(0.7, 1),
          .m2a_last = dice.uniform(0.5, 0.9),
          .a2m_first = dice.uniform(0.5, 0.9),
          .a2m_last = dice.uniform(0.4, 0.8),
          .a2r_first = dice.uniform(0.8, 1),
          .a2r_last = dice.uniform(0.2, 0.5),
          .a2r_width = dice.uniform(1.2, 1.5),
          .r_hysteresis_K = dice.uniform(2.5, 5.5),
          .strain_deficit = dice.uniform(0.05, 0.25),
          .saturation_Pa = dice.uniform(40e6, 100e6),
          .parallel_share = dice.uniform(0.5, 0.8),
          .specific_heat_1_K = dice.uniform(1e-4, 5e-4),
          .conduction = dice.uniform(0.65, 0.95),
          .clamp_resistance_m = dice.uniform(0.15e-3, 0.45e-3)};
}

}  // namespace

WireUnit random_unit(hal::Family family, std::uint64_t seed) {
  Dice dice(seed);
  WireUnit unit{family, seed, files::load_wire(std::string(files::default_wire)), 0, {}};
  unit.wire.name = fmt::format("{} {}", hal::family_name(family), seed);
  Wire<double>& w = unit.wire.wire;
  const double limit_N = w.limits.stress_Pa * w.geometry.area_m2();
  w.geometry.length_m *= dice.factor(0.005);
  w.geometry.diameter_m *= dice.factor(0.01);
  w.limits.stress_Pa = w.stress_Pa(limit_N);

  ThreePhaseParams<double>& k = w.kinetics;
  const Surface<double> a2m = first_surface(k.a2m_a2r);
  const Surface<double> a2r = second_surface(k.a2m_a2r);
  k.m2a = vary(k.m2a, 1.5, dice);
  // One draw per statement: the order in which arguments are evaluated differs between compilers.
  const Surface<double> varied_a2r = vary(a2r, 1.5, dice);
  k.a2m_a2r = pair_surfaces(vary(a2m, 1.5, dice), varied_a2r);
  vary(w.material.martensite, dice);
  vary(w.material.r_phase, dice);
  vary(w.material.austenite, dice);

  HeatParams<double>& h = w.heat;
  const double latent = dice.factor(0.06);
  h.latent_m2a_J_kg *= latent;
  h.latent_r2a_J_kg *= latent;
  h.specific_heat_J_kgK *= dice.factor(0.04);
  h.clamp_conductivity_W_mK *= dice.factor(0.10);
  const StillAir air = still_air(w.geometry.diameter_m);
  h.convection_W_m2K = air.convection_W_m2K;
  h.convection_W_m2K2 = air.convection_W_m2K2;

  unit.scatter_K = dice.uniform(0.3, 0.7);
  if (family == hal::Family::ihyp) {
    // In the observers' model R-phase follows martensite's surfaces exactly; here it does not.
    k.separate_r2a = true;
    k.r2a = vary(k.m2a, 1.0, dice);
    k.separate_r2m = true;
    k.r2m = vary(first_surface(k.a2m_a2r), 1.0, dice);
  } else if (family == hal::Family::sublayers) {
    unit.structure.sublayers = random_structure(dice);
  } else if (family == hal::Family::free_energy) {
    unit.structure.free_energy = random_barriers(dice);
  } else {
    unit.structure.smooth_hardening = random_hardening(dice);
  }
  return unit;
}

Wire<double> WireUnit::type_file() const {
  std::mt19937_64 random;
  const auto cold = hal::make_simulated_wire(family, wire.wire, structure, 0, random);
  const std::string preset(files::default_wire);
  const double length_m = files::load_wire(preset).wire.geometry.length_m;
  return files::load_wire(preset, {{"wire.resistance_ohm_per_m",
                                    fmt::format("{}", cold->resistance_ohm() / length_m)}})
      .wire;
}

}  // namespace smaservo::bench
