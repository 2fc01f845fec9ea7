#pragma once
// JSON schemas of the bridge's messages and requests, and one ROS 2 message definition. Foxglove
// accepts a channel or a service only if each schema gives exactly one type for each member
// (neither null nor one of two types), and lists the members of each object.

#include <string>
#include <string_view>

namespace smaservo::page {

std::string bridge_schema();
std::string live_schema();
/// The same values as a ROS 2 message: one float32 for each signal, in the order of signal_rows;
/// names are in lower case, as ROS 2 demands.
std::string live_definition();
std::string state_schema();
std::string commission_schema();

/// The schema of a request with these members, such as "node:integer signals:strings
/// trigger?:string"; the last one here may be missing.
std::string request_schema(std::string_view members);
/// The schema of an answer, whose members PROTOCOL.md describes.
std::string answer_schema();

}  // namespace smaservo::page
