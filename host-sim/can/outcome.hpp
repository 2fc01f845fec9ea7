#pragma once
// What a command has made so, for a person: one line each, which ends in a line break. The
// functions read the node; they throw UserError.

#include "firmware/faults.hpp"
#include "host-sim/can/settings.hpp"
#include "host-sim/units.hpp"

namespace smaservo::can {

/// How long the wire may be heated now.
std::string enabled_text(Remote& remote);
std::string disabled_text(Remote& remote, Units units);
/// Where the wire is after this time, and within what of the target it counts as reached (6067h).
std::string moved_text(Remote& remote, std::int32_t target_um, double took_s, Units units);
std::string stored_text();
/// `before`: the faults that were latched. Waits up to 1 s until the heat is off.
std::string faults_reset_text(Remote& remote, FaultSet before);

/// The values of the objects that are about to change; empty where an object cannot be read.
std::vector<Bytes> values_before(Remote& remote, const std::vector<Change>& changes);
/// One line for each: "strain.proportional_W: 0 -> 0.5", "strain.proportional_W: was 0.5 already"
std::string changed_text(const std::vector<Change>& changes, const std::vector<Bytes>& before);
/// The same for the parameters that a file has changed.
std::string restored_text(const std::vector<Difference>& differences, Units units);

/// Puts parameters on trial for this time, all together, and says until when they hold. Throws if
/// an object cannot be tried or a trial is in force already.
std::string begin_trial(Remote& remote, const std::vector<Change>& changes, double seconds);
/// End a trial; they throw if there is none.
std::string keep_trial(Remote& remote);
std::string revert_trial(Remote& remote);

/// To be called after the command of the network management, which has no answer: a started node
/// answers to SDO, a stopped one is silent, and one that was reset reports its start, for which
/// restarted_text() waits up to 3 s. started_text() and restarted_text() throw if it does not.
std::string started_text(Remote& remote);
std::string stopped_text(Remote& remote);
std::string restarted_text(Remote& remote);

}  // namespace smaservo::can
