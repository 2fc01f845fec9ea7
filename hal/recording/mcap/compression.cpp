#include "hal/recording/mcap/compression.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <lz4frame.h>
#include <new>
#include <zstd.h>

#include "hal/recording/mcap/records.hpp"
#include "model/files/error.hpp"

namespace smaservo::hal::mcap {
namespace {

constexpr int quickest = 1;
constexpr int largest_window = 26;  // 64 MiB: the largest chunk that Reader accepts
constexpr std::size_t first_room = std::size_t{1} << 16U;

/// How far a decompression has come.
struct Progress {
  std::size_t used = 0;   ///< decompressed bytes so far
  std::size_t taken = 0;  ///< compressed bytes consumed so far
  bool done = false;      ///< the compressed bytes are used up and were complete
};

/// Calls `step` with the free room behind `bytes` until it reports that it is done; `step` returns
/// what is wrong.
template <class Step>
std::string grow(std::uint64_t size, std::string& bytes, const Step& step) {
  // One byte more than allowed shows that there is too much.
  const auto most = static_cast<std::size_t>(size) + 1;
  Progress now;
  bytes.resize(std::min(most, first_room));
  while (!now.done) {
    if (now.used == bytes.size()) {
      if (now.used == most) {
        return fmt::format("is longer than the {} bytes that it should have", size);
      }
      bytes.resize(std::min(most, 2 * bytes.size()));
    }
    const Progress before = now;
    std::string problem = step(bytes.data() + now.used, bytes.size() - now.used, now);
    if (!problem.empty()) {
      return problem;
    }
    if (!now.done && now.used == before.used && now.taken == before.taken) {
      return "is cut off";
    }
  }
  bytes.resize(now.used);
  return now.used == size ? ""
                          : fmt::format("has {} bytes where it should have {}", now.used, size);
}

std::string from_zstd(std::string_view packed, std::uint64_t size, std::string& bytes) {
  const std::unique_ptr<ZSTD_DStream, std::size_t (*)(ZSTD_DStream*)> stream(ZSTD_createDStream(),
                                                                             ZSTD_freeDStream);
  if (!stream) {
    throw std::bad_alloc();
  }
  ZSTD_inBuffer in{packed.data(), packed.size(), 0};
  ZSTD_DCtx_setParameter(stream.get(), ZSTD_d_windowLogMax, largest_window);
  return grow(size, bytes, [&](char* to, std::size_t room, Progress& now) -> std::string {
    ZSTD_outBuffer out{to, room, 0};
    const std::size_t left = ZSTD_decompressStream(stream.get(), &out, &in);
    if (ZSTD_isError(left) != 0) {
      return ZSTD_getErrorName(left);
    }
    // More frames may follow one that has ended.
    now = {now.used + out.pos, in.pos, left == 0 && in.pos == in.size};
    return "";
  });
}

std::string from_lz4(std::string_view packed, std::uint64_t size, std::string& bytes) {
  LZ4F_dctx* made = nullptr;
  if (LZ4F_isError(LZ4F_createDecompressionContext(&made, LZ4F_VERSION)) != 0) {
    throw std::bad_alloc();
  }
  const std::unique_ptr<LZ4F_dctx, LZ4F_errorCode_t (*)(LZ4F_dctx*)> context(
      made, LZ4F_freeDecompressionContext);
  return grow(size, bytes, [&](char* to, std::size_t room, Progress& now) -> std::string {
    std::size_t out = room;
    std::size_t in = packed.size() - now.taken;
    const std::size_t left =
        LZ4F_decompress(context.get(), to, &out, packed.data() + now.taken, &in, nullptr);
    if (LZ4F_isError(left) != 0) {
      return LZ4F_getErrorName(left);
    }
    now = {now.used + out, now.taken + in, left == 0 && now.taken + in == packed.size()};
    return "";
  });
}

}  // namespace

struct Compressor::Context {
  std::unique_ptr<ZSTD_CCtx, std::size_t (*)(ZSTD_CCtx*)> zstd{ZSTD_createCCtx(), ZSTD_freeCCtx};
  std::string packed;
};

Compressor::Compressor() : context_(std::make_unique<Context>()) {
  if (!context_->zstd) {
    throw std::bad_alloc();
  }
}
Compressor::~Compressor() = default;
Compressor::Compressor(Compressor&&) noexcept = default;
Compressor& Compressor::operator=(Compressor&&) noexcept = default;

std::string_view Compressor::compress(std::string_view bytes) {
  std::string& packed = context_->packed;
  packed.resize(std::max(packed.size(), ZSTD_compressBound(bytes.size())));
  const std::size_t size = ZSTD_compressCCtx(context_->zstd.get(), packed.data(), packed.size(),
                                             bytes.data(), bytes.size(), quickest);
  if (ZSTD_isError(size) != 0) {
    throw files::UserError(fmt::format("zstd: {}", ZSTD_getErrorName(size)));
  }
  return std::string_view(packed).substr(0, size);
}

std::string decompress(std::string_view name, std::string_view packed, std::uint64_t size,
                       std::string& bytes) {
  if (name == zstd) {
    return from_zstd(packed, size, bytes);
  }
  if (name == lz4) {
    return from_lz4(packed, size, bytes);
  }
  return fmt::format("compression {}; known are zstd and lz4", name);
}

}  // namespace smaservo::hal::mcap
