#pragma once
// Faults of the estimate and of the loop that is closed over it.

#include "firmware/safety/faults/row.hpp"

namespace smaservo {

inline constexpr FaultRow estimate_faults[] = {
    {Fault::model_divergence, FaultClass::F2, Clears::command, 0xFF30, "model_divergence", 0.5,
     "The measured resistance differs from the model's by far more than the observer's own "
     "uncertainty.",
     "A wrong wire file, a wire that has changed, a wrong load reading, sense leads with a fault.",
     "Replay the trace with this wire file; identify the wire again."},
    {Fault::estimate_invalid, FaultClass::F2, Clears::command, 0xFF31, "estimate_invalid", 0,
     "The observer's result is not a number.",
     "Settings far from any wire, or an error in this program.",
     "The wire file; please report it with the trace."},
    {Fault::estimate_unsure, FaultClass::F2, Clears::command, 0xFF32, "estimate_unsure", 5,
     "The observer does not know the strain of the wire, which the mode in force needs.",
     "Switched on while the wire was hot or half cooled; a wire that is not the one of the file.",
     "Let the wire cool, then arm; or heat it once fully in current or power mode."},
    {Fault::following_error, FaultClass::F2, Clears::command, 0x8611, "following_error", 0,
     "The strain deviated from its reference by more than trips.following_error for "
     "trips.following_s.",
     "A set-point out of reach under this load, a limit that acts, gains too low, cooling "
     "slower than the trajectory asks for.",
     "The limit reasons in the freeze frame; trajectory.cooling_rate_1_s."},
    {Fault::power_balance, FaultClass::W, Clears::itself, 0xFF33, "power_balance", 5,
     "Resistance and power contradict each other: the observer can explain them only by an ambient "
     "temperature or a heat loss at the end of its range.",
     "Strong draught, a wire in a tube or a liquid, a wrong gain of current or voltage.",
     "What surrounds the wire; wire.heat; the gains against a known resistor."},
    {Fault::ambient_range, FaultClass::B, Clears::itself, 0x4110, "ambient_range", 1,
     "The ambient temperature is not between trips.min_ambient_K and trips.max_ambient_K.",
     "A hot or cold place, a sensor that is warmed by the board.",
     "The air at the wire: if too warm, the wire cannot stretch again; if too cold, it needs more "
     "power."},
    {Fault::started_outside, FaultClass::B, Clears::itself, 0x8613, "started_outside", 0.02,
     "Before arming, the wire is already outside its limits of strain, stress or temperature.",
     "A load that is too high or blocked, a wire that is still hot, limits that do not fit.",
     "limits.stress_Pa against the load; wait until the wire is cold."},
};

}  // namespace smaservo
