#pragma once
// The numbers behind the figures of paper 000. What the paper measured is here a simulated wire of
// the family `sublayers`, which is not the model; the model is what `identify` makes of its runs.

#include <array>
#include <vector>

#include "host-sim/identify/classic.hpp"
#include "host-sim/identify/fit.hpp"
#include "model/wire.hpp"

namespace smaservo::paper_000 {

/// The wire of the paper, smartflex-76um.
const Wire<double>& paper_wire();

/// One heating from 20 to 150 °C and the cooling back, at constant stress in a bath.
struct BathRun {
  double stress_MPa;
  std::vector<double> temperature_K, strain;
  std::vector<double> resistivity_ohm_m;  ///< of the wire as long as it is, at constant volume
  std::vector<Phases<double>> phases;

  std::size_t rows() const { return temperature_K.size(); }
  std::size_t hottest() const { return rows() / 2; }
};
BathRun simulated_bath_run(double stress_MPa);
BathRun model_bath_run(const Wire<double>& wire, double stress_MPa);

/// Heat flow into a wire without load that a calorimeter heats from 20 to 100 °C and cools, at
/// 10 K/min; above 0 is into the wire.
struct CalorimetryRun {
  std::vector<double> temperature_K, power_W_kg;
  std::vector<double> transforming_W_kg;  ///< what of it is latent heat
  std::vector<double> strain, resistivity_ohm_m;

  std::size_t hottest() const { return temperature_K.size() / 2; }
};
CalorimetryRun simulated_calorimetry();

/// Fifteen as in the paper, most of them low ('Experimental results').
inline constexpr std::array stresses_MPa{10.0,  15.0,  20.0,  25.0,  30.0,  40.0,  50.0, 60.0,
                                         100.0, 150.0, 200.0, 250.0, 300.0, 350.0, 400.0};

/// As `identify` reads it.
Run as_run(const BathRun& run);
Run as_run(const CalorimetryRun& run);

// The paper's three stages ('Parameterization method'); each takes a few seconds, once.

/// What `identify` finds from the calorimetry, beginning with the preset.
const FitResult& fitted_without_stress();

/// From one level of stress alone; the first is the one without stress.
struct Level {
  double stress_MPa;
  Wire<double> wire;
};
/// Each begins with what the level below has found.
const std::vector<Level>& fitted_levels();

/// From six levels at once, beginning with the one without stress.
const Wire<double>& fitted_model();

}  // namespace smaservo::paper_000
