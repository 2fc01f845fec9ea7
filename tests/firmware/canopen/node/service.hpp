#pragma once

#include <cstdint>

namespace smaservo::canopen {

/// Whose frames are made of bytes.
enum class Service : std::uint8_t { sdo, pdo, lss, nmt, all };

}  // namespace smaservo::canopen
