#pragma once
// The model's prediction of a measured run: strain and resistance at the points that a fit
// compares. It is templated on the scalar, so that automatic differentiation uses the same model as
// the observer.

#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

#include "host-sim/identify/fit/cost/balanced_plant.hpp"
#include "host-sim/identify/fit/cost/strained_plant.hpp"
#include "host-sim/identify/fit/jet_fraction.hpp"
#include "host-sim/identify/runs/run.hpp"
#include "model/wire/plant.hpp"

namespace smaservo::identify {

/// A run thinned for the fit. The wire is advanced step by step; after some of the steps,
/// prediction and measurement are compared. All vectors of one kind have the same length.
struct FitRun {
  std::string name;
  RunKind kind;
  // One element for every step:
  std::vector<double> dt_s;     ///< joule, imposed
  std::vector<double> power_W;  ///< joule, imposed and settled: mean over the step
  /// Mean square of the current, for the voltage drop along the leads.
  std::vector<double> current2_A2;
  std::vector<double> stress_Pa;      ///< bath, joule, settled
  std::vector<double> given_strain;   ///< imposed: at the end of the step
  std::vector<double> temperature_K;  ///< bath, calorimetry
  /// Calorimetry with time: rate of heating or cooling in the row; empty without time.
  std::vector<double> rate_K_s;
  double ambient_K = room_K;  ///< joule, imposed, settled: measured, or a first guess
  // One element for every comparison:
  std::vector<std::size_t> after;  ///< number of the step
  std::vector<double> strain;      ///< NaN if there is none
  std::vector<double> resistance_ohm;
  std::vector<double> measured_stress_Pa;  ///< imposed
  /// Calorimetry: heat flow into the wire, positive when it is heated.
  std::vector<double> power_W_kg;
  /// Calorimetry: half way between the usual heat flow of heating and that of cooling, which lies
  /// near the instrument's zero; 0 if the sample is only heated or only cooled.
  double middle_power_W_kg = 0;

  bool has_strain = false;
  bool has_resistance = false;
};

/// The parameters that belong to one run and not to the wire.
template <class T>
struct Circumstances {
  T ambient_K;
  T loss;             ///< factor on the heat loss
  T strain_zero;      ///< strain at which the run's readings have their zero
  T resistance_gain;  ///< gain of the run's resistance readings
  T rate_K_s;         ///< calorimetry without time: rate of heating and cooling
  T power_zero_W_kg;  ///< calorimetry: zero of the heat flow
};

/// The parameters that the readings of all runs share.
template <class T>
struct CircuitGuess {
  T lead_ohm;   ///< resistance in series with the wire between the sense leads
  T load_gain;  ///< reading divided by the true load
};

/// Everything that a prediction depends on.
template <class T>
struct Assumed {
  Wire<T> wire;
  CircuitGuess<T> circuit;
  Circumstances<T> here;
};

inline double number_of(double x) {
  return x;
}
/// The value of x without its derivatives.
template <class T>
double number_of(const T& x) {
  return x.a;
}

/// Strain and resistance at a comparison, and the effect of an error of the strain on the
/// resistance.
template <class T>
struct Predicted {
  T strain;          ///< calorimetry: heat flow in W/kg; imposed: stress in Pa
  T resistance_ohm;  ///< 0 in calorimetry and with an imposed strain
  /// Relative change of the resistance per strain if martensite takes the place of austenite, or of
  /// R-phase.
  T for_austenite, for_r_phase;
  Phases<double> phases;
};

template <class T>
void explain(const Material<T>& material, const Phases<T>& z, const T& stress_Pa, Predicted<T>& p) {
  const Resistivity<T> rho = resistivity(material, z, {material.reference_K, stress_Pa});
  const StrainSlopes<T> by = strain_slopes(material, stress_Pa);
  p.for_austenite = rho.per_martensite / (rho.value * by.martensite) + T(2);
  p.for_r_phase =
      (rho.per_martensite - rho.per_r_phase) / (rho.value * (by.martensite - by.r_phase)) + T(2);
  p.phases = {number_of(z.martensite), number_of(z.r_phase)};
}

/// The temperature above ambient at which the loss balances this power in the long run.
template <class T>
T settled_above_K(const ThermalBody<T>& body, const T& loss, const T& power_W) {
  using std::sqrt;
  if (!(T(0) < power_W)) {
    return T(0);
  }
  // P = loss (a θ + b θ²)
  const T p = power_W / loss;
  return T(2) * p /
         (body.loss_W_K + sqrt(body.loss_W_K * body.loss_W_K + T(4) * body.loss_W_K2 * p));
}

namespace detail {

template <class T>
void predict_calorimetry(const FitRun& run, const typename Plant<ThreePhase<T>>::Params& plant,
                         const HeatParams<T>& heat, const Circumstances<T>& c,
                         std::vector<Predicted<T>>& predicted) {
  using K = ThreePhase<T>;
  auto state = K::rest(plant.kinetics, {T(run.temperature_K.front()), T(0)});
  std::size_t at = 0;
  for (std::size_t i = 0; i < run.temperature_K.size(); ++i) {
    const Phases<T> before = K::phases(state);
    const double T_before = i == 0 ? run.temperature_K[0] : run.temperature_K[i - 1];
    const double change_K = run.temperature_K[i] - T_before;
    K::advance(plant.kinetics, state, {T(run.temperature_K[i]), T(0)});
    const Phases<T> after = K::phases(state);
    if (at < run.after.size() && run.after[at] == i) {
      const double size_K = std::abs(change_K);
      const T taken = heat.specific_heat_J_kgK * T(change_K) -
                      heat.latent_m2a_J_kg * (after.martensite - before.martensite) -
                      heat.latent_r2a_J_kg * (after.r_phase - before.r_phase);
      const T rate_K_s = run.rate_K_s.empty() ? c.rate_K_s : T(run.rate_K_s[i]);
      const T flow = size_K > 0 ? taken * rate_K_s / T(size_K) : T(0);
      predicted.push_back({c.power_zero_W_kg + flow, T(0), T(0), T(0), {}});
      ++at;
    }
  }
}

}  // namespace detail

/// The input of the plant in each step, under the assumptions on circuit, load cell and air.
template <class T>
struct Acting {
  const FitRun& run;
  const Assumed<T>& assumed;

  T power_W(std::size_t i) const {
    return T(run.power_W[i]) - T(run.current2_A2[i]) * assumed.circuit.lead_ohm;
  }
  PlantInput<T> at(std::size_t i) const {
    return {power_W(i), T(run.stress_Pa[i]) / assumed.circuit.load_gain, assumed.here.ambient_K};
  }
  /// With an imposed strain.
  StrainedInput<T> strained_at(std::size_t i) const {
    return {power_W(i), T(run.given_strain[i]) - assumed.here.strain_zero, assumed.here.ambient_K};
  }
};

template <class T>
typename Plant<ThreePhase<T>>::Params plant_of(RunKind kind, const Assumed<T>& assumed) {
  auto plant = plant_params(assumed.wire);
  plant.body.loss_W_K *= assumed.here.loss;
  plant.body.loss_W_K2 *= assumed.here.loss;
  if (kind == RunKind::bath) {
    plant.ends.share = T(0);  // no clamp is colder than the bath
  }
  if (kind == RunKind::imposed) {
    // A wire reverses after any change. What it would transform until a threshold and make up for
    // then would be a jump of the stress.
    plant.kinetics.smallest_reversal_K = T(0);
  }
  return plant;
}

/// The greatest stress that the model gives a wire whose strain is imposed: beyond its limit a
/// wire's surfaces say less and less.
inline double most_stress_Pa(const Wire<double>& wire) {
  return 1.5 * wire.limits.stress_Pa;
}

/// The steps of the plain plant in a run that is heated by current; none in others.
struct Path {
  std::vector<BalancedStep> steps;     ///< joule
  StrainedStep at_rest{};              ///< imposed: before the first step
  std::vector<StrainedStep> strained;  ///< imposed
};
inline Path path_of(const FitRun& run, const Assumed<double>& assumed) {
  Path path;
  const bool imposed = run.kind == RunKind::imposed;
  if ((run.kind != RunKind::joule && !imposed) || run.after.empty()) {
    return path;
  }
  const Acting<double> acting{run, assumed};
  if (imposed) {
    StrainedPlant plant(plant_of(run.kind, assumed), most_stress_Pa(assumed.wire),
                        assumed.here.ambient_K, acting.strained_at(0).strain);
    path.at_rest = plant.step();
    path.strained.reserve(run.after.back() + 1);
    for (std::size_t i = 0; i <= run.after.back(); ++i) {
      plant.advance(acting.strained_at(i), run.dt_s[i]);
      path.strained.push_back(plant.step());
    }
    return path;
  }
  BalancedPlant plant(plant_of(run.kind, assumed),
                      {assumed.here.ambient_K, acting.at(0).stress_Pa});
  path.steps.reserve(run.after.back() + 1);
  for (std::size_t i = 0; i <= run.after.back(); ++i) {
    plant.advance(acting.at(i), run.dt_s[i]);
    path.steps.push_back({plant.temperature_K(), plant.capacity_J_K()});
  }
  return path;
}

/// Fills `predicted` with an element for each comparison. `path` is the result of path_of() for the
/// values of `assumed`. A run starts from a wire that was cooled to its first temperature.
template <class T>
void predict(const FitRun& run, const Assumed<T>& assumed, const Path& path,
             std::vector<Predicted<T>>& predicted) {
  using K = ThreePhase<T>;
  predicted.clear();
  const auto params = plant_of(run.kind, assumed);
  if (run.kind == RunKind::calorimetry) {
    detail::predict_calorimetry(run, params, assumed.wire.heat, assumed.here, predicted);
    return;
  }
  const Acting<T> acting{run, assumed};
  const T ambient_K = assumed.here.ambient_K;
  if (run.kind == RunKind::imposed) {
    FollowingStrainedPlant<T> plant(params, ambient_K, path.at_rest, acting.strained_at(0).strain);
    std::size_t at = 0;
    for (std::size_t i = 0; at < run.after.size(); ++i) {
      plant.advance(path.strained[i], acting.strained_at(i), run.dt_s[i]);
      if (run.after[at] == i) {
        predicted.push_back({plant.stress_Pa() * assumed.circuit.load_gain, T(0), T(0), T(0), {}});
        ++at;
      }
    }
    return;
  }
  const auto settled_K = [&](std::size_t i) {
    return run.kind == RunKind::bath
               ? T(run.temperature_K[i])
               : ambient_K + settled_above_K(params.body, T(1), acting.at(i).power_W);
  };
  const bool in_time = run.kind == RunKind::joule;
  const T stress_Pa = acting.at(0).stress_Pa;
  FollowingPlant<T> plant(params, {in_time ? ambient_K : settled_K(0), stress_Pa});
  std::size_t at = 0;
  for (std::size_t i = 0; i < run.stress_Pa.size() && at < run.after.size(); ++i) {
    if (in_time) {
      plant.advance(path.steps[i], acting.at(i), run.dt_s[i]);
    } else {
      plant.move({settled_K(i), acting.at(i).stress_Pa});
    }
    if (run.after[at] == i) {
      const typename Plant<K>::State state{plant.state(), T(0)};
      Predicted<T> here{};
      here.strain = Plant<K>::strain(params, state) + assumed.here.strain_zero;
      here.resistance_ohm =
          Plant<K>::resistance_ohm(params, state, ambient_K) * assumed.here.resistance_gain +
          assumed.circuit.lead_ohm;
      explain(params.material, Plant<K>::phases(state), acting.at(i).stress_Pa, here);
      predicted.push_back(here);
      ++at;
    }
  }
}

}  // namespace smaservo::identify
