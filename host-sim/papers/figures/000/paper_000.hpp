#pragma once
// The data behind the figures of paper 000. The paper's measurements are replaced by a simulated
// wire of the family `sublayers`, which differs from the model. The model is the one that
// `identify` finds from its runs.

#include <array>
#include <vector>

#include "host-sim/identify/classic.hpp"
#include "host-sim/identify/fit/fit.hpp"
#include "model/wire/wire.hpp"

namespace smaservo::figures::paper_000 {

/// The wire of the paper, smartflex-76um.
const Wire<double>& paper_wire();

/// One heating from 20 to 150 °C and the cooling back, at constant stress in a bath. The wire comes
/// from -60 °C, so it begins as martensite.
struct BathRun {
  double stress_MPa;
  std::vector<double> temperature_K, strain;
  /// Computed with the wire's present length, at constant volume.
  std::vector<double> resistivity_ohm_m;
  std::vector<Phases<double>> phases;

  std::size_t rows() const { return temperature_K.size(); }
  std::size_t hottest() const { return rows() / 2; }
};
BathRun simulated_bath_run(double stress_MPa);
BathRun model_bath_run(const Wire<double>& wire, double stress_MPa);

/// Heat flow into a wire without load that a calorimeter heats from 20 to 100 °C and cools, at 10
/// K/min; positive into the wire.
struct CalorimetryRun {
  std::vector<double> temperature_K, power_W_kg;
  std::vector<double> transforming_W_kg;  ///< part of the heat flow that is latent heat
  std::vector<double> strain, resistivity_ohm_m;

  std::size_t hottest() const { return temperature_K.size() / 2; }
};
CalorimetryRun simulated_calorimetry();

/// Temperatures of the greatest heat flows, which are the dashed lines of figure 1.
struct Peaks {
  double m2a_K, a2r_K, r2m_K;
};
Peaks peaks(const CalorimetryRun& run);

/// Fifteen stresses as in the paper, most of them low ('Experimental results').
inline constexpr std::array stresses_MPa{10.0,  15.0,  20.0,  25.0,  30.0,  40.0,  50.0, 60.0,
                                         100.0, 150.0, 200.0, 250.0, 300.0, 350.0, 400.0};

/// The run as `identify` reads it: every second row, preceded by a row with the temperature from
/// which the wire comes.
identify::Run as_run(const BathRun& run);
identify::Run as_run(const CalorimetryRun& run);

// The paper's three stages ('Parameterization method'); each takes a few seconds when first called.

/// The fit of `identify` to the calorimetry, starting from the preset.
const identify::FitResult& fitted_without_stress();

/// A fit to one level of stress alone; the first level has no stress.
struct Level {
  double stress_MPa;
  Wire<double> wire;
};
/// A2R can be identified well up to this stress ('Stress dependence of the transformation
/// parameters').
inline constexpr double max_a2r_MPa = 100;
/// Each fit starts from the one without stress, those above max_a2r_MPa from the one at
/// max_a2r_MPa. In the paper each starts from the level below; `identify` stays close to its start,
/// so errors would then add up from level to level.
const std::vector<Level>& fitted_levels();

/// The fit to six levels at once, starting from the fit without stress.
const Wire<double>& fitted_model();

/// The quality of the resistance as a measure of the strain (figure 20), over the strains that both
/// directions pass through.
struct SelfSensing {
  /// Greatest difference of the resistance on cooling and that on heating at the same strain, as a
  /// share of the resistance's span; negative if heating has more.
  double gap;
  /// Root mean square deviation of the strain from the best straight line, as a share of the
  /// strain's span.
  double deviation;
};
SelfSensing self_sensing(const BathRun& run);
/// The resistance of the whole wire in each row.
std::vector<double> resistances_ohm(const BathRun& run);

/// Figure 5: the results of fit_classics() and fit_adaptable() for the same cycle.
std::vector<identify::ClassicFit> transformation_functions(const BathRun& run);
inline constexpr double function_stress_MPa = 200;

/// Figure 6: the parts of the normalised temperature at a converted fraction; they add up to
/// ihyp_temperature(). Each hyperbola leads to one end of the curve.
struct IhypParts {
  double initial, target, line;
};
IhypParts ihyp_parts(const IhypShape<double>& shape, double converted);

/// Figure 8: martensite over temperature on the outer curves, and on the way back from a
/// temperature on the heating curve, without stress and R-phase.
struct InnerLoop {
  std::vector<double> temperature_K;  ///< in rising order
  std::vector<double> heating, cooling;
  std::vector<double> back_K, back;  ///< in falling order
};
InnerLoop inner_loop();

// Figures 9 and 10: the effect of one step on the fractions before it. The parts of a bar add up to
// 1.
/// Parts from the bottom up; m2a and r2a become austenite.
struct HeatingBar {
  double temperature_K;
  double martensite, m2a, austenite, r2a, r_phase;
};
/// Parts from the bottom up; `either` is austenite for which A2M and A2R compete; r2m becomes
/// martensite.
struct CoolingBar {
  double temperature_K;
  double martensite, a2m, either, austenite, a2r, r_phase, r2m;
};
std::vector<HeatingBar> heating_bars();
std::vector<CoolingBar> cooling_bars();
inline constexpr double bar_step_K = 3;
inline constexpr double heating_bars_MPa = 50;
inline constexpr double cooling_bars_MPa = 110;  ///< stress at which A2M and A2R meet

}  // namespace smaservo::figures::paper_000
