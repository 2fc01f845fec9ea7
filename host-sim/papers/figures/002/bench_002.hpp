#pragma once
// The bench of paper 002, simulated: a Flexinol LT wire under weights or a spring, heated by a
// current, with resistance, load and displacement measured. The paper does not give the diameter.
// With 0.15 mm the paper's 1 N is 57 MPa, at which there is as much R-phase as its figure 2 shows,
// and its 175 MPa is the maker's limit.

#include <string>
#include <vector>

#include "firmware/bench/scenario/scenario.hpp"
#include "host-sim/papers/fits/strain_resistance_fit.hpp"

namespace smaservo::figures::bench_002 {

files::WireDescription wire();
double stress_Pa(double load_N);

/// Loads of the calibration: 15 to 175 MPa as in section 3.2, without those too light for lines
/// (see identify_strain_resistance).
std::vector<double> calibration_stresses_Pa();

/// Two full cycles, then loops with incomplete heating and loops with incomplete cooling (section
/// 3.3), at 200 Hz.
identify::Run calibration_run(hal::Family family, double stress_Pa);
/// The estimator identified from the runs at these loads.
fits::StrainResistanceFit calibrate(hal::Family family);

/// A spring with 20 MPa in the long wire and 170 MPa in a wire that is 3 % shorter.
hal::SpringLoad spring();
hal::Sensors sensors();
/// Least current, at which the resistance can still be measured.
inline constexpr double min_current_A = 0.06;
/// The experiments of section 4.5, on a wire that was just calibrated, with other levels of the
/// power than in the calibration.
identify::Run validation_run(hal::Family family, const hal::Load& load);

/// Mean error as the paper defines it: in per cent of a stroke of 4 %.
double mean_error_percent(const std::vector<double>& strain, const identify::Run& run);

/// The run with a constant stress, as assumed by someone without a load cell. The paper does not
/// give this stress; here it is the highest of the run, which causes the largest error.
identify::Run with_constant_stress(identify::Run run);

}  // namespace smaservo::figures::bench_002
