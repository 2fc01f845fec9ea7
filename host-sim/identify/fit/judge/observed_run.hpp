#pragma once
// A measured run as the observer sees it, and how the observer errs in it. The fit judges the
// wires by this, because a model that explains a run better is not always better for the observer,
// which corrects the model by the resistance.

#include <cstddef>
#include <vector>

#include "host-sim/identify/fit/cost/prediction.hpp"
#include "host-sim/identify/runs/run.hpp"
#include "observer/estimate.hpp"

namespace smaservo::identify {

/// Means over steps of about 4 ms, which an observer resolves as well as single rows at 1 kHz.
struct ObservedRun {
  double ambient_K = 0;  ///< of the air, as the fit has found it
  // One element for every step:
  std::vector<double> dt_s;
  std::vector<Measurement<double>> seen;
  std::vector<double> strain;  ///< measured at the step's end; NaN where there is none
};

/// Errors before are not counted: the observer has to find the air and the resistance first.
inline constexpr double observer_settles_s = 1;

/// `run` must have time, current and voltage; `as_fitted` tells lead, load cell, air and the zero
/// of the strain.
ObservedRun observed_run(const Run& run, const Assumed<double>& as_fitted);

/// How often the observer's reported deviation is right, and how far it is off.
struct ObserverErrors {
  double sum = 0;  ///< of the strain's errors without sign
  std::size_t within_2_sd = 0;
  std::size_t count = 0;

  double mean() const { return sum / static_cast<double>(count); }
  double share_within_2_sd() const {
    return static_cast<double>(within_2_sd) / static_cast<double>(count);
  }
  ObserverErrors& operator+=(const ObserverErrors& other);
};

/// The errors after the first second, from four starts that the observer has to correct: the air 4
/// K colder or warmer than it is, the resistance read 0.5 % too high or too low.
ObserverErrors observer_errors(const ObservedRun& run, const Wire<double>& wire);

}  // namespace smaservo::identify
