#pragma once
// The experiments of paper 003 on the project's wires, which give the data of its figures.

#include "hal/sim/simulated_wire.hpp"
#include "host-sim/papers/figures/003/temperature_loop.hpp"
#include "host-sim/papers/fits/preisach_fit.hpp"

namespace smaservo::figures {

/// The wire, the 76 um SmartFlex, in its loop. The paper's wire transforms between 25 and 75 °C,
/// this one between 25 and 120 °C.
LoopSetup loop_003();
/// The initial controller, three times as fast as the wire itself, and the final one.
FixedController fixed_003(const LoopSetup& setup);
AdaptiveController adaptive_003(const LoopSetup& setup);
/// Decaying oscillations of the temperature, at 150 MPa or with a stress that oscillates, too.
std::vector<LoopReference> references_003(bool dynamic);

/// Identified from reversal curves at 100, 125, 150, 175 and 200 MPa in a bath (003 figure 4).
fits::PreisachFit fit_003(hal::Family family, fits::StressShift shift);

/// 003 figure 5: the loop's true temperature and stress, the wire's strain under them, and the
/// strain of the model.
struct Validation {
  std::vector<LoopRow> rows;
  std::vector<double> strain, model;
  double rms;  ///< error relative to a stroke of 4 %
};
Validation validation_003(hal::Family family, const fits::PreisachWire& model, bool dynamic);

}  // namespace smaservo::figures
