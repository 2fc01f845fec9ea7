#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace smaservo {

/// FNV-1a with 128 bits. It finds accidents: a file that has changed, a row that was cut off. It is
/// no protection against somebody who makes two texts with the same hash on purpose.
class Hash {
 public:
  void add(std::string_view text);
  /// 32 hexadecimal digits.
  std::string hex() const;

 private:
  std::uint64_t high_ = 0x6c62272e07bb0142, low_ = 0x62b821756295c58d;
};

std::string hash_of(std::string_view text);

}  // namespace smaservo
