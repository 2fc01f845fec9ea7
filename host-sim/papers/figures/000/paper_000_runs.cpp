#include <cmath>
#include <limits>
#include <memory>
#include <random>
#include <string>

#include "hal/sim/simulated_wire.hpp"
#include "host-sim/papers/figures/000/paper_000.hpp"
#include "model/files/wire/wire_file.hpp"
#include "model/wire/plant.hpp"

namespace smaservo::figures::paper_000 {
namespace {

using Model = Plant<ThreePhase<double>>;

constexpr double coldest_K = 293.15;
constexpr double martensite_K = 213.15;       // temperature before the run: 'full martensite'
constexpr double hottest_K = 423.15;          // 'Experimental results': not above 150 °C
constexpr double calorimetry_hot_K = 373.15;  // figure 1
constexpr double rate_K_s = 10.0 / 60;        // usual in calorimetry; the paper does not give it

std::unique_ptr<hal::SimulatedWire> simulated_wire() {
  std::mt19937_64 random(1);
  return hal::make_simulated_wire(hal::Family::sublayers, paper_wire(), {}, 0.5, random);
}

/// Temperatures from cold to hot and back; their number is odd, and the hottest is in the middle.
std::vector<double> cycle_K(double max_K, double step_K) {
  const auto steps = static_cast<int>(std::lround((max_K - coldest_K) / step_K));
  std::vector<double> all;
  for (int i = -steps; i <= steps; ++i) {
    all.push_back(coldest_K + step_K * (steps - std::abs(i)));
  }
  return all;
}

double resistivity_of(double resistance_ohm, double strain) {
  // R = ρ L_0/A_0 (1 + 2 ε)
  return resistance_ohm / (paper_wire().length_per_area_1_m() * (1 + 2 * strain));
}

/// The model of a wire in a bath, in which the clamps are not colder than the wire.
class BathModel {
 public:
  BathModel(const Wire<double>& wire, double stress_Pa) : params_(plant_params(wire)) {
    params_.ends.share = 0;
    state_ = Model::rest(params_, {martensite_K, stress_Pa});
  }
  void soak(double temperature_K, double stress_Pa) {
    ThreePhase<double>::advance(params_.kinetics, state_.kinetics, {temperature_K, stress_Pa});
  }
  double strain() const { return Model::strain(params_, state_); }
  double resistance_ohm() const {
    return Model::resistance_ohm(params_, state_, Model::temperature_K(state_));
  }
  Phases<double> phases() const { return Model::phases(state_); }

 private:
  Model::Params params_;
  Model::State state_{};
};

template <class AnyWire>
BathRun bath_run(AnyWire& wire, double stress_MPa) {
  BathRun run{stress_MPa, cycle_K(hottest_K, 1), {}, {}, {}};
  for (const double T : run.temperature_K) {
    wire.soak(T, 1e6 * stress_MPa);
    run.strain.push_back(wire.strain());
    run.resistivity_ohm_m.push_back(resistivity_of(wire.resistance_ohm(), wire.strain()));
    run.phases.push_back(wire.phases());
  }
  return run;
}

identify::FitOptions quick() {
  identify::FitOptions options;
  options.variants = false;
  return options;
}

}  // namespace

const Wire<double>& paper_wire() {
  static const Wire<double> wire = files::load_wire("smartflex-76um").wire;
  return wire;
}

BathRun simulated_bath_run(double stress_MPa) {
  const auto wire = simulated_wire();
  wire->rest(martensite_K, 1e6 * stress_MPa);
  return bath_run(*wire, stress_MPa);
}

BathRun model_bath_run(const Wire<double>& wire, double stress_MPa) {
  BathModel model(wire, 1e6 * stress_MPa);
  return bath_run(model, stress_MPa);
}

CalorimetryRun simulated_calorimetry() {
  const HeatParams<double>& heat = paper_wire().heat;
  const auto wire = simulated_wire();
  wire->rest(martensite_K, 0);
  wire->soak(coldest_K, 0);
  CalorimetryRun run{cycle_K(calorimetry_hot_K, 0.5), {}, {}, {}, {}};
  double before_K = coldest_K - 1e-3;
  for (const double T : run.temperature_K) {
    const Phases<double> before = wire->phases();
    wire->soak(T, 0);
    const Phases<double> after = wire->phases();
    const double latent_J_kg = -heat.latent_m2a_J_kg * (after.martensite - before.martensite) -
                               heat.latent_r2a_J_kg * (after.r_phase - before.r_phase);
    const double step_K = T - before_K;
    const double per_K = rate_K_s / std::abs(step_K);
    run.transforming_W_kg.push_back(latent_J_kg * per_K);
    run.power_W_kg.push_back((heat.specific_heat_J_kgK * step_K + latent_J_kg) * per_K);
    run.strain.push_back(wire->strain());
    run.resistivity_ohm_m.push_back(resistivity_of(wire->resistance_ohm(), wire->strain()));
    before_K = T;
  }
  return run;
}

identify::Run as_run(const BathRun& run) {
  constexpr double nothing = std::numeric_limits<double>::quiet_NaN();
  identify::Run bath{};
  bath.name = "bath";
  bath.kind = identify::RunKind::bath;
  bath.temperature_K = {martensite_K};
  bath.strain = {nothing};
  bath.resistance_ohm = {nothing};
  const std::vector<double> ohm = resistances_ohm(run);
  for (std::size_t i = 0; i < run.rows(); i += 2) {
    bath.temperature_K.push_back(run.temperature_K[i]);
    bath.strain.push_back(run.strain[i]);
    bath.resistance_ohm.push_back(ohm[i]);
  }
  bath.stress_Pa.assign(bath.temperature_K.size(), 1e6 * run.stress_MPa);
  return bath;
}

identify::Run as_run(const CalorimetryRun& run) {
  identify::Run calorimetry{};
  calorimetry.name = "calorimetry";
  calorimetry.kind = identify::RunKind::calorimetry;
  calorimetry.temperature_K = {martensite_K};
  calorimetry.power_W_kg = {0};  // there is no heat flow at rest
  calorimetry.temperature_K.insert(calorimetry.temperature_K.end(), run.temperature_K.begin(),
                                   run.temperature_K.end());
  calorimetry.power_W_kg.insert(calorimetry.power_W_kg.end(), run.power_W_kg.begin(),
                                run.power_W_kg.end());
  return calorimetry;
}

const identify::FitResult& fitted_without_stress() {
  static const identify::FitResult result =
      identify::fit_wire(paper_wire(), {as_run(simulated_calorimetry())}, quick());
  return result;
}

const Wire<double>& fitted_model() {
  static const Wire<double> wire = [] {
    std::vector<identify::Run> runs;
    for (const double stress_MPa : {10.0, 50.0, 100.0, 200.0, 300.0, 400.0}) {
      runs.push_back(as_run(simulated_bath_run(stress_MPa)));
    }
    return identify::fit_wire(fitted_without_stress().wire, runs, quick()).wire;
  }();
  return wire;
}

const std::vector<Level>& fitted_levels() {
  static const std::vector<Level> levels = [] {
    std::vector<Level> all{{0, fitted_without_stress().wire}};
    Wire<double> from = all.front().wire;
    for (const double stress_MPa : stresses_MPa) {
      const identify::Run run = as_run(simulated_bath_run(stress_MPa));
      all.push_back({stress_MPa, identify::fit_wire(from, {run}, quick()).wire});
      if (stress_MPa == max_a2r_MPa) {
        from = all.back().wire;
      }
    }
    return all;
  }();
  return levels;
}

}  // namespace smaservo::figures::paper_000
