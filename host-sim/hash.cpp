#include "host-sim/hash.hpp"

#include <fmt/format.h>

namespace smaservo {

// The prime is 2^88 + 0x13B. Products are made of 32 bits, since C++ has no integers of 128.
void Hash::add(std::string_view text) {
  constexpr std::uint64_t small_part = 0x13B;
  constexpr std::uint64_t lower_half = 0xFFFFFFFF;
  for (const char c : text) {
    low_ ^= static_cast<unsigned char>(c);
    const std::uint64_t lower = (low_ & lower_half) * small_part;
    const std::uint64_t upper = (low_ >> 32U) * small_part + (lower >> 32U);
    high_ = high_ * small_part + (upper >> 32U) + (low_ << 24U);
    low_ = (upper << 32U) | (lower & lower_half);
  }
}

std::string Hash::hex() const {
  return fmt::format("{:016x}{:016x}", high_, low_);
}

std::string hash_of(std::string_view text) {
  Hash hash;
  hash.add(text);
  return hash.hex();
}

}  // namespace smaservo
