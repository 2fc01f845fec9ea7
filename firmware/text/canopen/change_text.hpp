#pragma once
// Entries of the change log (2220h), in words.

#include <span>
#include <string>

#include "firmware/canopen/servo/change_log.hpp"

namespace smaservo::text {

/// "strain.proportional_W (2100h:1): 0 -> 0.5, by SDO";
/// "limits.current_A (2020h:2): stays 0.4; 99 by SDO is refused: value too high (abort 06090031h)"
std::string change_text(const canopen::LoggedChange& change);

/// Reads an entry of 2220h:2, which has ChangeLog::bytes bytes.
canopen::LoggedChange change_of(std::span<const std::uint8_t> bytes);

}  // namespace smaservo::text
