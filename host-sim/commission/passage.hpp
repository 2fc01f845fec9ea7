#pragma once
// The observer's passage through a run, as far as commissioning needs it.

#include <cstddef>
#include <vector>

#include "host-sim/identify/fit/judge/observed_run.hpp"
#include "model/wire/wire.hpp"

namespace smaservo::commission {

/// A run for the observer, and the steps after which it is asked for the strain of a reading.
struct ObservedWire {
  identify::ObservedRun run;
  double ambient_K;
  std::vector<std::size_t> anchor_steps;
};

/// Innovations are averaged over blocks: their errors are correlated over some tenths of a second.
inline constexpr double block_s = 0.2;

/// What the observer of a wire says in a run.
struct Passage {
  std::vector<double> at_anchors;  ///< strain
  std::vector<double> innovation;  ///< relative error of the resistance in each block
  /// At the end of each block; all of the same length.
  std::vector<double> time_s, strain, strain_sd, resistance_ohm, resistance_model_ohm;
  // Of the likeliest hypothesis at the end of the run.
  double ambient_off_K;  ///< of where it started
  double loss;           ///< factor
  double resistance;     ///< factor
};
Passage pass(const ObservedWire& seen, const Wire<double>& wire);

/// Root mean square of the innovations.
double innovation_rms(const Passage& passage);

}  // namespace smaservo::commission
