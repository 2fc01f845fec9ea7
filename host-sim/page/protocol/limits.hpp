#pragma once

#include <cstddef>

/// What a client may ask for in one message, and keep open.
namespace smaservo::page::limits {

inline constexpr std::size_t message_bytes = std::size_t{256} << 10U;  // a settings file has 30 kB
inline constexpr int depth = 32;                                       // of a JSON document
inline constexpr std::size_t subscriptions = 1024;
inline constexpr std::size_t names = 8192;  // of parameters
inline constexpr std::size_t calls = 64;    // services and parameters that are not answered yet

}  // namespace smaservo::page::limits
