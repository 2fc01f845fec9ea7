#pragma once
// The content of chunks, by Debian's libraries.

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

namespace smaservo::files::mcap {

/// Makes zstd frames at the quickest level, in memory that it keeps.
class Compressor {
 public:
  Compressor();
  ~Compressor();
  Compressor(const Compressor&) = delete;
  Compressor& operator=(const Compressor&) = delete;
  Compressor(Compressor&&) noexcept;
  Compressor& operator=(Compressor&&) noexcept;

  /// Valid until the next call.
  std::string_view compress(std::string_view bytes);

 private:
  struct Context;
  std::unique_ptr<Context> context_;
};

/// Turns `packed` into `bytes`, which grow no further than `size`: a length that lies costs no
/// memory. Empty: it is done, and these are `size` bytes; else what is wrong.
std::string decompress(std::string_view name, std::string_view packed, std::uint64_t size,
                       std::string& bytes);

}  // namespace smaservo::files::mcap
