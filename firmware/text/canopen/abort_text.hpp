#pragma once

#include <cstdint>
#include <string_view>

namespace smaservo::text {

/// The meaning of an SDO abort code of CiA 301; "" for an unknown code.
std::string_view abort_text(std::uint32_t code);

}  // namespace smaservo::text
