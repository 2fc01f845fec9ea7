#pragma once
// Faults of the wire, its clamps, its leads and its load.

#include "firmware/safety/faults/row.hpp"

namespace smaservo {

inline constexpr FaultRow wire_faults[] = {
    {Fault::wire_open, FaultClass::F1, Clears::command, 0xFF20, "wire_open", 0.003,
     "No current flows though some is given, or the resistance is far above the wire's.",
     "A broken wire, a crimp that has come off, a lead that is not plugged in.",
     "The wire and both crimps by eye and with an ohmmeter."},
    {Fault::wire_short, FaultClass::F0, Clears::command, 0x2320, "wire_short", 0.001,
     "The resistance is far below the wire's.",
     "The wire touches itself, a metal part or its leads; the settings name another wire.",
     "The wire along its whole path, cold and contracted; wire.length and wire.diameter."},
    {Fault::sense_lead_open, FaultClass::F1, Clears::command, 0xFF21, "sense_lead_open", 0.002,
     "Current flows, but the sense leads read next to no voltage.",
     "A sense lead that is broken or not plugged in, both leads at the same end, a dead short.",
     "Both sense leads from the wire's ends to the front end."},
    {Fault::resistance_jump, FaultClass::F1, Clears::command, 0xFF2F, "resistance_jump", 0.002,
     "The resistance has jumped by more than 8 %, faster than any wire can transform.",
     "A short across part of the wire, a bad crimp, a reading whose gain has changed.",
     "The wire along its whole path, both crimps; the gains of voltage and current."},
    {Fault::no_response, FaultClass::F1, Clears::command, 0xFF22, "no_response", 0.005,
     "The wire has been given more than enough heat to contract, but its resistance has not "
     "followed.",
     "Sense leads that are not on the wire, readings that do not come from it, a wire that is "
     "cooled much more than its settings say.",
     "That voltage and load follow a small current that is given by hand; wire.heat."},
    {Fault::over_temperature, FaultClass::F1, Clears::command, 0x4310, "over_temperature", 0.002,
     "By the model, the hottest spot of the wire is about to pass trips.temperature_K.",
     "A limit too close to what the load needs, a set-point out of reach, a wire that is better "
     "insulated than its settings say.",
     "limits.temperature_K well below the trip; the load's stress; what covers the wire."},
    {Fault::heat_limit, FaultClass::L, Clears::itself, 0xFF2E, "heat_limit", 0,
     "The heat put into the wire may have brought it to limits.temperature_K, even where the "
     "estimate is lower; the current is reduced.",
     "A set-point out of reach, strong draught or a cold place, an estimate that is wrong.",
     "The estimated temperature and heat loss against what surrounds the wire."},
    {Fault::overheat_onset, FaultClass::L, Clears::itself, 0xFF23, "overheat_onset", 0.005,
     "The rise of the resistance since the end of the transformation shows a wire more than 2 K "
     "above limits.temperature_K, even where the estimate is lower; the current is reduced.",
     "Less cooling or warmer air than the observer believes: a draught has ended, a cover.",
     "What surrounds the wire; wire.heat."},
    {Fault::overheat_signature, FaultClass::F1, Clears::command, 0xFF24, "overheat_signature",
     0.005,
     "The rise of the resistance since the end of the transformation shows a wire above "
     "trips.temperature_K that is still heated, even where the estimate is lower.",
     "A wire that is shielded from the air, power that is measured too low, a bad crimp.",
     "What covers the wire; the gains of voltage and current; each crimp's resistance."},
    {Fault::cooling_weak, FaultClass::W, Clears::itself, 0xFF34, "cooling_weak", 0,
     "The wire takes longer to cool than its file says, by the time until its resistance rises: it "
     "is "
     "cooled less; the power that it gets for long is reduced.",
     "A cover, a box, a fan that has stopped, warmer air than the observer believes.",
     "The live value cooling; what surrounds the wire; wire.heat."},
    {Fault::cooling_lost, FaultClass::F1, Clears::command, 0xFF35, "cooling_lost", 0,
     "By the time that it took to cool, the wire was above limits.temperature_K by more than 3 K.",
     "A cover, a box, a fan that has stopped, a wire file of another place.",
     "The live value cooling; what surrounds the wire; identify the wire where it works."},
    {Fault::heating_fast, FaultClass::W, Clears::itself, 0xFF25, "heating_fast", 0.002,
     "The wire heats faster than 70 % of trips.heating_rate_K_s.",
     "A current limit that is high for this wire.", "limits.current_A and limits.power_W."},
    {Fault::heating_rate, FaultClass::F1, Clears::command, 0xFF26, "heating_rate", 0.005,
     "The wire heats faster than trips.heating_rate_K_s.",
     "A current that is too high for this wire, the wire file of a thicker one, a short across "
     "part of the wire.",
     "The wire's diameter and length in its file; limits.power_W."},
    {Fault::load_lost, FaultClass::F1, Clears::command, 0xFF27, "load_lost", 0.02,
     "The wire is slack: its stress is below trips.slack_Pa.",
     "The load has come off, the mechanism hit a stop, the wire cooled while its load was held, "
     "the load cell has failed.",
     "That the load moves back freely; the load cell with a known weight; "
     "measurement.load_offset_N."},
    {Fault::over_stress, FaultClass::F2, Clears::command, 0xFF28, "over_stress", 0.01,
     "The stress is above trips.stress_Pa.",
     "A blocked mechanism, too much load, a spring that is too stiff.",
     "That the mechanism moves freely; the load at the contracted end."},
    {Fault::over_strain, FaultClass::F2, Clears::command, 0x8612, "over_strain", 0.02,
     "The estimated strain is not between trips.min_strain and trips.max_strain.",
     "A load that stretches the cold wire too far, limits that do not fit the mechanism.",
     "The mechanism's end stops; axis.zero_strain."},
    {Fault::slip_seen, FaultClass::W, Clears::itself, 0xFF29, "slip_seen", 0,
     "The stress fell suddenly while the resistance rose, as when a wire slips in its clamp; the "
     "warning stays for some seconds.",
     "A clamp that is loose or not made for this wire.", "A mark on the wire beside each clamp."},
    {Fault::clamp_slip, FaultClass::F2, Clears::command, 0xFF2A, "clamp_slip", 0,
     "The wire seems to have slipped in its clamp three times within some seconds, so strain and "
     "position are no longer right.",
     "A clamp that is loose or not made for this wire.",
     "Clamp the wire anew, then set axis.zero_strain."},
    {Fault::drift, FaultClass::B, Clears::itself, 0xFF2B, "drift", 1,
     "The wire's resistance differs from that of its file by more than trips.drift: it has aged.",
     "Fatigue, a permanently stretched wire, another wire, a corroded crimp.",
     "The wire's length without load; identify it again or replace it."},
    {Fault::cycles, FaultClass::W, Clears::itself, 0xFF2C, "cycles", 0,
     "The wire has done trips.cycles full cycles.", "The planned life of the wire is over.",
     "Replace the wire, then restart the device: it counts from 0 again."},
    {Fault::cold_resistance, FaultClass::B, Clears::itself, 0xFF2D, "cold_resistance", 0,
     "At arming, the wire's resistance was not between trips.resistance_low and "
     "trips.resistance_high times that of its file, or could not be measured.",
     "Another wire than the settings say, a bad crimp, a partial short, an open lead.",
     "The resistance with an ohmmeter, four wires, at room temperature; wire.length."},
    {Fault::duty, FaultClass::L, Clears::itself, 0x2313, "duty", 0.01,
     "The mean square of the current is more than 10 % above limits.duty; the current is reduced.",
     "A wire that is held hot for longer, or cooled more, than planned.",
     "limits.duty and limits.duty_window_s; draught at the wire."},
};

}  // namespace smaservo
