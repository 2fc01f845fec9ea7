#pragma once
// Faults of the supply, the output stage and its sensors.

#include "firmware/safety/faults/row.hpp"

namespace smaservo {

inline constexpr FaultRow drive_faults[] = {
    {Fault::supply_low, FaultClass::F1, Clears::command, 0x3220, "supply_low", 0.005,
     "The supply voltage is below drive.min_supply_V.",
     "The supply is switched off, too weak for the current, or its fuse has blown.",
     "The voltage at the board's terminals while the wire is heated; the supply's current limit."},
    {Fault::supply_high, FaultClass::F1, Clears::command, 0x3210, "supply_high", 0.002,
     "The supply voltage is above drive.max_supply_V.",
     "The wrong supply, or another load that feeds back into it.",
     "The voltage at the board's terminals; what else the supply feeds."},
    {Fault::over_current, FaultClass::F0, Clears::command, 0x2310, "over_current", 0,
     "The measured current is above trips.current_A.",
     "A driver that has lost control, a short in the wire, a trip too close to the limit.",
     "The driver with a resistor instead of the wire; trips.current_A against limits.current_A."},
    {Fault::current_saturated, FaultClass::F0, Clears::command, 0x2311, "current_saturated", 0,
     "The current reading is at the end of its scale, so the true current is not known.",
     "A short, a driver out of control, a full scale that is set too small, a broken shunt.",
     "measurement.current_full_scale_A against the front end; the shunt and its amplifier."},
    {Fault::voltage_saturated, FaultClass::F1, Clears::command, 0x3310, "voltage_saturated", 0.005,
     "The voltage reading is at the end of its scale, so the resistance is not known.",
     "An open wire, a wire longer than the front end is made for, a wrong full scale.",
     "The wire's connection; measurement.voltage_full_scale_V against current times resistance."},
    {Fault::current_offset, FaultClass::B, Clears::itself, 0x5210, "current_offset", 0,
     "The current sensor does not read zero while no current is given.",
     "A current sensor that has drifted or is broken, a leaking output stage.",
     "The reading with the supply unplugged: if it stays it is the sensor, if not a leak."},
    {Fault::current_control, FaultClass::F1, Clears::command, 0x8311, "current_control", 0.01,
     "The measured current differs from the given one.",
     "A faulty driver, a current sensor with a wrong gain, a current loop that is too slow.",
     "Given and measured current in the freeze frame; both against an ammeter."},
    {Fault::current_while_off, FaultClass::F0, Clears::command, 0x2312, "current_while_off", 0.003,
     "Current flows though none is given.",
     "A shorted output transistor, an output that kept its value, a second source at the wire.",
     "Disconnect the supply at once. Then the output stage, and what else touches the wire."},
    {Fault::driver_fault, FaultClass::F0, Clears::command, 0x5400, "driver_fault", 0,
     "The output stage reports a fault.",
     "Its own over-current or over-temperature protection has acted; its logic has no supply.",
     "The driver's own diagnosis; the wire and its leads for a short to ground."},
    {Fault::driver_warm, FaultClass::L, Clears::itself, 0xFF10, "driver_warm", 0.1,
     "The output stage is less than 10 K below trips.driver_K; the current is reduced.",
     "High current for a long time, poor cooling, a hot cabinet.",
     "The heat sink and the air around it; limits.duty."},
    {Fault::driver_hot, FaultClass::F1, Clears::command, 0x4210, "driver_hot", 0.02,
     "The output stage is hotter than trips.driver_K.",
     "Poor cooling, a driver that is shorted or works in its linear range.",
     "Heat sink, air, and whether the sensor reads right on a cold board."},
    {Fault::kelvin_mismatch, FaultClass::F1, Clears::command, 0x3311, "kelvin_mismatch", 0.01,
     "The voltage between the sense leads contradicts the voltage that feeds the wire.",
     "A sense lead on the wrong point, a crimp or lead of high resistance, a wrong gain.",
     "Each crimp's resistance; the sense leads at the wire's ends; the gain of both readings."},
};

}  // namespace smaservo
