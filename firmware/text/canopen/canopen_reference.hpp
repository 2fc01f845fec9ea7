#pragma once
// Makes the references to the node's object dictionary, for people and tools, from the firmware's
// tables.

#include <string>

namespace smaservo::text {

/// How an EDS says the defaults of REAL32 objects: CiA 306 does not tell how a real is written, so
/// that no way suits all readers.
enum class RealDefaults : unsigned char {
  none,     ///< for all that take a missing one, which is 0 to them: Lely, ros2_canopen,
            ///< python-canopen, canopen of npm
  decimal,  ///< for gocanopen, which refuses a real without; python-canopen shows them
};

/// firmware/reference/smaservo.eds, in the format of CiA 306.
std::string eds_text(RealDefaults reals = RealDefaults::none);
/// firmware/reference/smaservo.dbc: the frames of node 1 with their default mapping.
std::string dbc_text();
/// firmware/reference/OBJECTS.md.
std::string object_reference();

}  // namespace smaservo::text
