#pragma once

#include <cstdint>
#include <string_view>

namespace smaservo::text {

/// What an SDO abort code of CiA 301 means; "" for one that is unknown.
std::string_view abort_text(std::uint32_t code);

}  // namespace smaservo::text
