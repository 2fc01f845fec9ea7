#pragma once
// The frames of an SDO transfer of up to four bytes, which is one request and one answer (CiA 301,
// 7.2.4), and the frame that repeats the last command.

#include <optional>

#include "firmware/parameters/key.hpp"
#include "hal/can_frame.hpp"
#include "host-sim/page/servos/servo.hpp"

namespace smaservo::page {

/// The request that reads the object, or writes this value of two bytes.
hal::CanFrame sdo_request(unsigned node, Key key, std::optional<std::uint16_t> value);
/// The object that a request or an answer names.
Key sdo_key(const hal::CanFrame& frame);
/// The value in an answer to a read; none if it is refused or too long for one frame.
std::optional<std::uint32_t> sdo_value(const hal::CanFrame& answer);

/// Notes a controlword or a mode that a client writes.
void note_command(const hal::CanFrame& request, std::int64_t now_us, Commanded& commanded);
/// Whether the last command to an axis that a client has enabled has to be repeated.
bool needs_renewal(const Servo& servo, std::int64_t now_us);
/// A frame that repeats the last command by RPDO1 in its default mapping; if no controlword was
/// written, it switches the axis off.
hal::CanFrame command_pdo(const Servo& servo);

}  // namespace smaservo::page
