#pragma once
// Any kinetics with a heat balance, identified from measured runs by their strain: the same least
// squares for all kinetics, with numerical derivatives.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "host-sim/papers/fits/driven_steps.hpp"
#include "model/wire/plant.hpp"

namespace smaservo::fits {

/// A parameter that a fit may change. The prior of its deviation u is 0 ± 1.
template <class Model>
struct Adjustable {
  std::string key;
  std::function<void(Model&, double u)> apply;
};

/// A wire with these kinetics.
template <class K>
struct PlantModel {
  typename K::Params kinetics;
  Material<double> material;
  HeatParams<double> heat;
  Geometry<double> geometry;

  typename Plant<K>::Params plant() const {
    const Drive<double> room{room_K, 150e6};
    const ColdEnds<double> ends{1.74 * clamp_reach_m(geometry, heat) / geometry.length_m,
                                K::phases(K::rest(kinetics, room))};
    return {kinetics, material, thermal_body(geometry, heat), ends,
            geometry.length_m / geometry.area_m2()};
  }
};

/// Longest step of the plant's model here; longer ones are divided into substeps.
inline constexpr double longest_plant_step_s = 30e-3;

/// Runs a model through all steps; `see(params, state)` is called after each.
template <class K, class See>
void drive_plant(const PlantModel<K>& model, const DrivenSteps& steps, See see) {
  auto params = model.plant();
  if (steps.bath) {
    params.ends.share = 0;  // no clamp is colder than the bath
  }
  const double first_K = steps.bath ? steps.temperature_K.front() : steps.ambient_K;
  auto state = Plant<K>::rest(params, {first_K, steps.stress_Pa.front()});
  for (std::size_t i = 0; i < steps.stress_Pa.size(); ++i) {
    if (steps.bath) {
      K::advance(params.kinetics, state.kinetics, {steps.temperature_K[i], steps.stress_Pa[i]});
    } else {
      // Rounding down by up to half a step keeps a clock that jitters around the longest step from
      // doubling the work.
      const double wanted = std::ceil(steps.dt_s[i] / longest_plant_step_s - 0.5);
      const int parts = static_cast<int>(std::clamp(wanted, 1.0, 65536.0));
      for (int part = 0; part < parts; ++part) {
        Plant<K>::advance(params, state, {steps.power_W[i], steps.stress_Pa[i], steps.ambient_K},
                          steps.dt_s[i] / parts);
      }
    }
    see(params, state);
  }
}

/// Strain after every step.
template <class K>
std::vector<double> driven_strain(const PlantModel<K>& model, const DrivenSteps& steps) {
  std::vector<double> strain;
  strain.reserve(steps.stress_Pa.size());
  drive_plant(model, steps, [&](const auto& params, const auto& state) {
    strain.push_back(Plant<K>::strain(params, state));
  });
  return strain;
}

/// The deviations that minimise Σ (strain error / 0.05 %)² with a robust loss, all runs with equal
/// weight, plus Σ u². `strain_of(u, run)` is the model; it may be called by several threads at
/// once. The result is the same for any number of threads. Throws nothing.
using StrainOf =
    std::function<std::vector<double>(const std::vector<double>& u, const DrivenSteps&)>;
std::vector<double> fit_deviations(std::size_t count, const std::vector<DrivenSteps>& runs,
                                   const StrainOf& strain_of,
                                   const std::vector<std::vector<double>>& starts, int threads);

/// The model with the best deviations; the starts are tried first, and the best one is continued.
template <class K>
PlantModel<K> fit_plant(const PlantModel<K>& prior,
                        const std::vector<Adjustable<PlantModel<K>>>& adjustables,
                        const std::vector<identify::Run>& runs,
                        const std::vector<std::vector<double>>& starts, int threads) {
  const auto at = [&](const std::vector<double>& u) {
    PlantModel<K> model = prior;
    for (std::size_t i = 0; i < adjustables.size(); ++i) {
      adjustables[i].apply(model, u[i]);
    }
    return model;
  };
  std::vector<DrivenSteps> steps;
  steps.reserve(runs.size());
  for (const identify::Run& run : runs) {
    steps.push_back(thinned(run));
  }
  return at(fit_deviations(
      adjustables.size(), steps,
      [&](const std::vector<double>& u, const DrivenSteps& run) {
        return driven_strain(at(u), run);
      },
      starts, threads));
}

}  // namespace smaservo::fits
