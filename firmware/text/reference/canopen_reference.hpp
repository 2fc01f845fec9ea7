#pragma once
// Makes the references to the node's object dictionary, for people and tools, from the firmware's
// tables.

#include <string>

namespace smaservo::text {

/// firmware/reference/smaservo.eds, in the format of CiA 306.
std::string eds_text();
/// firmware/reference/smaservo.dbc: the frames of node 1 with their default mapping.
std::string dbc_text();
/// firmware/reference/OBJECTS.md.
std::string object_reference();

}  // namespace smaservo::text
