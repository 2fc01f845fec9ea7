#pragma once
// The runs of a simulated wire from which a Preisach model is identified.

#include "firmware/bench/scenario/scenario.hpp"
#include "host-sim/identify/runs/run.hpp"

namespace smaservo::figures {

/// The run that identifies a wire at one stress: cycles from cold to each of `curves` temperatures
/// and back, with a full cycle before and after. The temperatures are chosen for the wire's M2A so
/// that the first converts a little and the last nearly everything. Cold is 25 °C or colder.
/// stress_Pa must be within the wire's limits.
bench::BathScenario reversal_curves(const Wire<double>& wire, double stress_Pa, int curves);

/// The run measured in the bath of the scenario.
identify::Run bath_run(const bench::Scenario& scenario);

}  // namespace smaservo::figures
