#pragma once

#include <cstddef>

/// Bounds of a client's messages and open requests.
namespace smaservo::page::limits {

inline constexpr std::size_t message_bytes = std::size_t{256} << 10U;  // a settings file has 30 kB
inline constexpr int depth = 32;                                       // nesting of a JSON document
inline constexpr std::size_t subscriptions = 1024;
inline constexpr std::size_t names = 8192;  // names of parameters
// Calls of services and requests for parameters that are not answered yet.
inline constexpr std::size_t calls = 64;

}  // namespace smaservo::page::limits
