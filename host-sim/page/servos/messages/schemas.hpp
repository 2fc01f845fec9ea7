#pragma once
// JSON schemas of what the bridge says and is asked, and one ROS 2 message definition. Foxglove
// takes a channel or a service only where each schema has one type for each member (none is null,
// none of two types), and the members of each object.

#include <string>
#include <string_view>

namespace smaservo::page {

std::string bridge_schema();
std::string live_schema();
/// Of the same values as a ROS 2 message: one float32 for each signal, in the order of signal_rows,
/// in lower case, as the names of such a message must be.
std::string live_definition();
std::string state_schema();

/// Of a request with these members, as "node:integer signals:strings trigger?:string": the last may
/// be missing.
std::string request_schema(std::string_view members);
/// Of an answer, whose members PROTOCOL.md has.
std::string answer_schema();

}  // namespace smaservo::page
