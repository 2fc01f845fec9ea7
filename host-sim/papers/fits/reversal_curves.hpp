#pragma once
// The runs of a simulated wire that a Preisach model is identified from.

#include "firmware/bench/scenario/scenario.hpp"
#include "host-sim/identify/runs/run.hpp"

namespace smaservo::fits {

/// The run to identify a wire from at one stress: for each of `curves` temperatures from cold to
/// there and back, so chosen for the wire's M2A that the first converts a little and the last
/// nearly everything; a full cycle before and after. Cold is 25 °C or colder. stress_Pa as the wire
/// allows.
bench::BathScenario reversal_curves(const Wire<double>& wire, double stress_Pa, int curves);

/// The run that the scenario's bath measures.
identify::Run bath_run(const bench::Scenario& scenario);

}  // namespace smaservo::fits
