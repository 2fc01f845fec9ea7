#pragma once
// Makes the references to the node's object dictionary, for people and tools, from the firmware's
// tables.

#include <string>

namespace smaservo::text {

/// How an EDS writes the defaults of REAL32 objects. CiA 306 does not say how a real number is
/// written, so no way suits all readers.
enum class RealDefaults : unsigned char {
  none,     ///< no defaults: Lely, ros2_canopen, python-canopen and canopen of npm take 0 then
  decimal,  ///< decimal numbers: for gocanopen, which needs a default; python-canopen shows it
};

/// firmware/reference/smaservo.eds, in the format of CiA 306.
std::string eds_text(RealDefaults reals = RealDefaults::none);
/// firmware/reference/smaservo.dbc: the frames of node 1 with their default mapping.
std::string dbc_text();
/// firmware/reference/OBJECTS.md.
std::string object_reference();

}  // namespace smaservo::text
