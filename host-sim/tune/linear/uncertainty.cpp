#include "host-sim/tune/linear/uncertainty.hpp"

#include <cmath>

#include "firmware/bench/dice.hpp"

namespace smaservo::tune {
namespace {

constexpr double min_draught = 0.8;

/// A surface whose branch is shifted, has another width and another curvature.
Surface<double> vary(Surface<double> surface, double known, bench::Dice& dice) {
  const double width_K = surface.finish_K[0] - surface.start_K[0];
  const double shift_K = 2 * dice.deviation(known) * width_K;
  const double wider_K = dice.deviation(known) * width_K;
  const double by_stress = dice.factor(0.02);
  const double curvature = dice.factor(0.10);
  surface.start_K[0] += shift_K - 0.5 * wider_K;
  surface.finish_K[0] += shift_K + 0.5 * wider_K;
  for (auto* temperature_K : {&surface.start_K, &surface.finish_K}) {
    (*temperature_K)[1] *= by_stress;
    (*temperature_K)[2] *= by_stress;
  }
  for (double& coefficient : surface.curvature) {
    coefficient *= curvature;
  }
  return surface;
}

void vary(Phase<double>& phase, double known, bench::Dice& dice) {
  phase.strain *= dice.factor(known);
  phase.modulus_Pa *= dice.factor(0.05);
  const double resistivity = dice.factor(0.003);
  phase.resistivity_ohm_m *= resistivity;
  phase.resistivity_ohm_m_K *= resistivity;
  phase.resistivity_ohm_m_Pa *= resistivity;
}

TunedPlant random_plant(const TunedPlant& plant, bench::Dice& dice) {
  TunedPlant p = plant;
  Wire<double>& w = p.wire;
  const double known = w.accuracy.strain / w.nominal_stroke;
  ThreePhaseParams<double>& k = w.kinetics;
  // The values are drawn one after the other, because the evaluation order of arguments differs
  // between compilers.
  k.m2a = vary(k.m2a, known, dice);
  const Surface<double> a2m = vary(first_surface(k.a2m_a2r), known, dice);
  const Surface<double> a2r = vary(second_surface(k.a2m_a2r), known, dice);
  k.a2m_a2r = pair_surfaces(a2m, a2r);
  k.r2a = k.separate_r2a ? vary(k.r2a, known, dice) : k.m2a;
  k.r2m = k.separate_r2m ? vary(k.r2m, known, dice) : a2m;
  vary(w.material.martensite, known, dice);
  vary(w.material.r_phase, known, dice);
  vary(w.material.austenite, known, dice);
  const double latent = dice.factor(0.06);
  w.heat.latent_m2a_J_kg *= latent;
  w.heat.latent_r2a_J_kg *= latent;
  w.heat.specific_heat_J_kgK *= dice.factor(0.04);
  p.draught *= min_draught * std::pow(max_draught / min_draught, dice.uniform(0, 1));
  p.ambient_K += dice.uniform(-3, 3);
  return p;
}

}  // namespace

std::vector<TunedPlant> uncertain_plants(const TunedPlant& plant, int count, std::uint64_t seed) {
  std::vector<TunedPlant> all{plant, plant, plant};
  all[1].draught *= min_draught;
  all[2].draught *= max_draught;
  bench::Dice dice(seed);
  while (static_cast<int>(all.size()) < count) {
    all.push_back(random_plant(plant, dice));
  }
  return all;
}

}  // namespace smaservo::tune
