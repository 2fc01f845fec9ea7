#pragma once
// Compression of the content of chunks, by the libraries that Debian has.

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

namespace smaservo::hal::mcap {

/// Makes zstd frames at the quickest level; keeps its working memory between calls.
class Compressor {
 public:
  Compressor();
  ~Compressor();
  Compressor(const Compressor&) = delete;
  Compressor& operator=(const Compressor&) = delete;
  Compressor(Compressor&&) noexcept;
  Compressor& operator=(Compressor&&) noexcept;

  /// The result is valid until the next call.
  std::string_view compress(std::string_view bytes);

 private:
  struct Context;
  std::unique_ptr<Context> context_;
};

/// Decompresses `packed` into `bytes`, which grow no further than `size`: a false length in the
/// file costs no memory. Returns an empty text if `bytes` are complete and exactly `size` bytes;
/// otherwise what is wrong.
std::string decompress(std::string_view name, std::string_view packed, std::uint64_t size,
                       std::string& bytes);

}  // namespace smaservo::hal::mcap
