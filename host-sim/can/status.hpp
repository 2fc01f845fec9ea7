#pragma once
// The state of a servo as text for people.

#include "firmware/faults.hpp"
#include "host-sim/can/remote.hpp"
#include "host-sim/units.hpp"

namespace smaservo::can {

/// Identity, versions, states, loop and bus.
std::string info_text(Remote& remote, Units units);

/// Faults that are active or latched, the first cause, the conditions that block and limit, the
/// error history.
std::string faults_text(Remote& remote);

/// The last writes and refused writes, the newest last.
std::string changes_text(Remote& remote);

FaultSet latched_faults(Remote& remote);

/// The first cause of the latched faults; Fault::none if there is none.
Fault first_cause(Remote& remote);

}  // namespace smaservo::can
