#pragma once

#include "firmware/command.hpp"
#include "hal/sim/board.hpp"

namespace smaservo {

/// One step: what went in, what came out, and, of a simulation, what was true when the sample was
/// taken.
struct Turn {
  double time_s;
  Inputs<double> inputs;
  Command<double> command;
  Output<double> output;
  SimTruth truth;
};

}  // namespace smaservo
