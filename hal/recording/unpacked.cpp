#include "hal/recording/unpacked.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <limits>
#include <lzma.h>
#include <zlib.h>
#include <zstd.h>

#include "model/files/error.hpp"

namespace smaservo::hal {
namespace {

/// A socket of packets discards what does not fit.
constexpr std::size_t block_size = std::size_t{1} << 16;
constexpr std::size_t looked_at = 8;
constexpr std::string_view gzip_magic = "\x1F\x8B", zstd_magic = "\x28\xB5\x2F\xFD";
constexpr std::string_view xz_magic =
    "\xFD"
    "7zXZ";

class Gzip final : public Unpacked::Unpacker {
 public:
  Gzip() {
    constexpr int only_gzip = 16;
    if (inflateInit2(&stream_, only_gzip + MAX_WBITS) != Z_OK) {
      throw files::UserError("gzip: no memory");
    }
  }
  ~Gzip() override { inflateEnd(&stream_); }
  Gzip(const Gzip&) = delete;
  Gzip& operator=(const Gzip&) = delete;

  std::size_t unpack(std::string_view& in, char* to, std::size_t room) override {
    if (whole_ && !gzip_magic.starts_with(in.substr(0, gzip_magic.size()))) {
      in = {};  // gzip, too, leaves out what is behind its data
      return 0;
    }
    if (whole_) {
      inflateReset(&stream_);
      whole_ = false;
    }
    constexpr auto most = static_cast<std::size_t>(std::numeric_limits<uInt>::max());
    const auto taken = std::min(in.size(), most);
    const auto given = std::min(room, most);
    // zlib reads through this pointer and does not write. NOLINTNEXTLINE(*-cast)
    stream_.next_in = const_cast<Bytef*>(reinterpret_cast<const Bytef*>(in.data()));
    stream_.avail_in = static_cast<uInt>(taken);
    stream_.next_out = reinterpret_cast<Bytef*>(to);  // NOLINT(*-reinterpret-cast)
    stream_.avail_out = static_cast<uInt>(given);
    const int result = inflate(&stream_, Z_NO_FLUSH);
    if (result != Z_OK && result != Z_STREAM_END && result != Z_BUF_ERROR) {
      throw files::UserError(fmt::format("the gzip data are damaged: {}",
                                         stream_.msg == nullptr ? "no memory" : stream_.msg));
    }
    whole_ = result == Z_STREAM_END;
    in.remove_prefix(taken - stream_.avail_in);
    return given - stream_.avail_out;
  }
  bool is_whole() const override { return whole_; }

 private:
  z_stream stream_{};
  bool whole_ = false;
};

class Zstd final : public Unpacked::Unpacker {
 public:
  std::size_t unpack(std::string_view& in, char* to, std::size_t room) override {
    ZSTD_inBuffer from{in.data(), in.size(), 0};
    ZSTD_outBuffer out{to, room, 0};
    const std::size_t left = ZSTD_decompressStream(stream_.get(), &out, &from);
    if (ZSTD_isError(left) != 0) {
      throw files::UserError(fmt::format("the zstd data are damaged: {}", ZSTD_getErrorName(left)));
    }
    whole_ = left == 0;
    in.remove_prefix(from.pos);
    return out.pos;
  }
  bool is_whole() const override { return whole_; }

 private:
  std::unique_ptr<ZSTD_DStream, std::size_t (*)(ZSTD_DStream*)> stream_{ZSTD_createDStream(),
                                                                        ZSTD_freeDStream};
  bool whole_ = false;
};

class Xz final : public Unpacked::Unpacker {
 public:
  Xz() { begin(); }
  ~Xz() override { lzma_end(&stream_); }
  Xz(const Xz&) = delete;
  Xz& operator=(const Xz&) = delete;

  std::size_t unpack(std::string_view& in, char* to, std::size_t room) override {
    if (whole_) {
      // Zeros may fill up what is behind the data; anything else must be another such file.
      in.remove_prefix(std::min(in.find_first_not_of('\0'), in.size()));
      if (in.empty()) {
        return 0;
      }
      begin();
      whole_ = false;
    }
    // NOLINTNEXTLINE(*-reinterpret-cast)
    stream_.next_in = reinterpret_cast<const std::uint8_t*>(in.data());
    stream_.avail_in = in.size();
    stream_.next_out = reinterpret_cast<std::uint8_t*>(to);  // NOLINT(*-reinterpret-cast)
    stream_.avail_out = room;
    const lzma_ret result = lzma_code(&stream_, LZMA_RUN);
    if (result != LZMA_OK && result != LZMA_STREAM_END && result != LZMA_BUF_ERROR) {
      throw files::UserError(result == LZMA_MEMLIMIT_ERROR
                                 ? "the xz data need more than 128 MiB of memory; unxz them first"
                                 : "the xz data are damaged");
    }
    whole_ = result == LZMA_STREAM_END;
    in.remove_prefix(in.size() - stream_.avail_in);
    return room - stream_.avail_out;
  }
  bool is_whole() const override { return whole_; }

 private:
  void begin() {
    constexpr std::uint64_t most_memory = std::uint64_t{128} << 20U;
    if (lzma_stream_decoder(&stream_, most_memory, 0) != LZMA_OK) {
      throw files::UserError("xz: no memory");
    }
  }

  lzma_stream stream_ = LZMA_STREAM_INIT;
  bool whole_ = false;
};

/// What the user may do with a file that begins so; null: it may be a table as text.
const char* way_out(std::string_view head) {
  using namespace std::string_view_literals;
  constexpr std::pair<std::string_view, const char*> foreign[] = {
      {"BZh"sv, "is compressed by bzip2; bunzip2 it first"},
      {"\xD0\xCF\x11\xE0"sv,
       "is an old Office file (.xls), or one with a password; save the sheet as .xlsx or CSV"},
      {"\x89HDF"sv,
       "is an HDF5 file that MATLAB has not written; save the columns as CSV, or by MATLAB's "
       "save()"},
      {"TDSm"sv, "is a TDMS file; export it as text from LabVIEW or DIAdem"}};
  for (const auto& [magic, way] : foreign) {
    if (head.starts_with(magic)) {
      return way;
    }
  }
  return nullptr;
}

}  // namespace

Unpacked::Unpacked(Read read) : read_(std::move(read)) {
  block_.resize(block_size);
  std::size_t used = 0;
  for (std::size_t got = 1; got > 0 && used < looked_at; used += got) {
    got = read_(block_.data() + used, block_.size() - used);
    ended_ = got == 0;
  }
  in_ = std::string_view(block_).substr(0, used);
  if (in_.starts_with(gzip_magic)) {
    unpacker_ = std::make_unique<Gzip>();
  } else if (in_.starts_with(zstd_magic)) {
    unpacker_ = std::make_unique<Zstd>();
  } else if (in_.starts_with(xz_magic)) {
    unpacker_ = std::make_unique<Xz>();
  }
  for (std::size_t got = 1; got > 0 && head_.size() < looked_at;) {
    std::string part(block_size, '\0');
    got = read_on(part.data(), part.size());
    head_.append(part, 0, got);
  }
  if (const char* way = way_out(head_)) {
    throw files::UserError(way);
  }
}

Unpacked::~Unpacked() = default;

std::size_t Unpacked::read(char* to, std::size_t room) {
  if (head_.empty()) {
    return read_on(to, room);
  }
  const std::size_t part = head_.copy(to, room);
  head_.erase(0, part);
  return part;
}

/// Reads a block of the file; false at its end.
bool Unpacked::fill() {
  const std::size_t got = ended_ ? 0 : read_(block_.data(), block_.size());
  ended_ = got == 0;
  in_ = std::string_view(block_).substr(0, got);
  return got > 0;
}

std::size_t Unpacked::read_on(char* to, std::size_t room) {
  if (!unpacker_) {
    if (in_.empty()) {
      return ended_ ? 0 : read_(to, room);
    }
    const std::size_t part = in_.copy(to, room);
    in_.remove_prefix(part);
    return part;
  }
  for (;;) {
    if (in_.empty() && !fill() && unpacker_->is_whole()) {
      return 0;
    }
    const std::size_t made = unpacker_->unpack(in_, to, room);
    if (made > 0) {
      return made;
    }
    if (in_.empty() && ended_ && !unpacker_->is_whole()) {
      throw files::UserError("the compressed data end in the middle; the file was cut off");
    }
  }
}

}  // namespace smaservo::hal
