#pragma once
// Faults of the machine: readings, timing, commands, bus, settings.

#include "firmware/safety/faults/row.hpp"

namespace smaservo {

inline constexpr FaultRow machine_faults[] = {
    {Fault::sensor_invalid, FaultClass::F1, Clears::command, 0xFF40, "sensor_invalid", 0.003,
     "The reading of current, voltage or load is not a number.",
     "A sensor that is not connected or whose converter reports an error.",
     "Each reading in the freeze frame; the cable of the one that is missing."},
    {Fault::sample_stale, FaultClass::F1, Clears::command, 0xFF41, "sample_stale", 0,
     "No new sample has come for timing.sample_timeout_s.",
     "The converter or its bus has stopped, the machine is overloaded.",
     "The front end's supply and bus; the loop's timing."},
    {Fault::sample_frozen, FaultClass::F1, Clears::command, 0xFF42, "sample_frozen", 0.005,
     "The samples repeat: the same sequence number, or the same readings though the given "
     "current has changed.",
     "A converter that hangs, a driver that delivers old values as new ones.",
     "The front end's sequence counter; reset the front end."},
    {Fault::control_invalid, FaultClass::F1, Clears::command, 0x6100, "control_invalid", 0,
     "The control law's result is no usable current, so none was given.",
     "A set-point that is not a number, gains far beyond reason, or an error in this program.",
     "Set-point and gains in the freeze frame."},
    {Fault::deadline_missed, FaultClass::F1, Clears::command, 0xFF43, "deadline_missed", 0,
     "The loop was late more than ten times within about a second.",
     "Another program on the same core, no real-time rights, a bus that blocks.",
     "The histogram of the loop's timing; priority and isolation of its core."},
    {Fault::command_timeout, FaultClass::F2, Clears::command, 0xFF44, "command_timeout", 0,
     "No command has come for timing.command_timeout_s while the device was armed.",
     "The controlling program has stopped or its connection is lost.",
     "The command source; its period against timing.command_timeout_s."},
    {Fault::emergency_stop, FaultClass::F0, Clears::command, 0x9000, "emergency_stop", 0,
     "The emergency stop is pressed, or its line is open.",
     "Somebody pressed it; a broken cable counts as pressed.",
     "Why it was pressed, before anything else; then its cable."},
    {Fault::cooling_timeout, FaultClass::F0, Clears::command, 0xFF45, "cooling_timeout", 0.01,
     "The current has been off for long enough for the wire to be cold, but the wire is still "
     "heated.",
     "An output that leaks or pulses, too briefly for current_while_off.",
     "Disconnect the supply at once. Then the output stage's input and its leakage."},
    {Fault::bus_lost, FaultClass::F2, Clears::command, 0x8140, "bus_lost", 0.1,
     "The field bus is bus-off, or the command source on it is no longer heard.",
     "A cable, the termination, another bit rate, a command source that is switched off.",
     "Termination and error counters of the bus."},
    {Fault::duplicate_node, FaultClass::F2, Clears::command, 0x8150, "duplicate_node", 0,
     "Another node on the bus uses the same node-id.", "Two devices with one identity.node_id.",
     "The node-id of every device on the bus."},
    {Fault::unclean_boot, FaultClass::B, Clears::acknowledge, 0xFF46, "unclean_boot", 0,
     "The last run ended by a watchdog, a crash or a loss of power while armed.",
     "An error in the program, an overloaded machine, a supply that fails under load.",
     "The last freeze frame and the system's log; then acknowledge."},
    {Fault::store_corrupt, FaultClass::B, Clears::reset, 0x5530, "store_corrupt", 0,
     "The stored settings are damaged or incomplete.",
     "Power lost while writing, a worn memory, a store of another program.",
     "Store a complete set of settings and restart."},
    {Fault::bad_configuration, FaultClass::B, Clears::itself, 0x6320, "bad_configuration", 0,
     "The settings contradict each other or the board.",
     "Limits beyond the wire's or the board's, a trip inside of a limit.",
     "The message of the settings' check, which names the parameters."},
    {Fault::not_configured, FaultClass::B, Clears::itself, 0x6310, "not_configured", 0,
     "The device has no settings for its wire.", "A new device.",
     "Write settings for the wire that is mounted, and store them."},
    {Fault::store_outdated, FaultClass::B, Clears::itself, 0x5531, "store_outdated", 0,
     "What was stored last is lost in part: the settings in force may be older, their limits "
     "wider.",
     "A worn memory, power lost while storing, a file that was removed or is of a newer release.",
     "Which values differ: the log at the start and 'host-sim can changes' say it. Set what is "
     "wrong, then store (1010h): that acknowledges it and makes the store whole. Or restore "
     "(1011h) and reset."},
    {Fault::loop_stalled, FaultClass::F1, Clears::command, 0xFF47, "loop_stalled", 0,
     "The loop stood still for longer than a command's lease of three periods, so nobody knows "
     "what the output did meanwhile; the wire is taken to have been heated all the time.",
     "The process was stopped or the machine suspended, another program on the same core, a driver "
     "that blocks; on a microcontroller an erase of its flash.",
     "missed and the longest wake_us in the status; what else ran at that time; that the one-shot "
     "ended the heat."},
};

}  // namespace smaservo
