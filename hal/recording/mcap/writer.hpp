#pragma once
// Writes an MCAP file with the messages of one channel, in compressed chunks with their indexes and
// a summary at the end, so that Foxglove and PlotJuggler can open it at once.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "hal/recording/mcap/compression.hpp"
#include "hal/recording/mcap/records.hpp"

namespace smaservo::hal::mcap {

/// Describes the messages.
struct Stream {
  std::string schema_name;
  std::string schema;  ///< JSON Schema
  std::string topic;
};
using Texts = std::vector<std::pair<std::string, std::string>>;

/// Collects the bytes of the file until the caller takes and writes them. Keeps one chunk in
/// memory, and 64 bytes for each closed chunk, which the index at the end needs.
class Writer {
 public:
  /// `library` names the writing program in the header.
  explicit Writer(std::string_view library, bool compressed = true);

  /// At most one metadata record and one stream may be given, before the first message.
  void metadata(std::string_view name, const Texts& entries);
  void stream(const Stream& stream);
  /// Adds a message to the chunk; closes the chunk when it is large enough.
  void message(std::uint64_t time_ns, std::string_view data);
  /// Closes the chunk if it has messages.
  void close_chunk();
  /// Closes the chunk and adds the summary and the end; nothing may follow.
  void finish();

  std::uint64_t messages() const { return closed_ + in_chunk_; }
  /// The number of messages in closed chunks.
  std::uint64_t closed() const { return closed_; }
  /// The bytes made since the last call: always whole records.
  std::string take();

 private:
  struct Chunk {
    std::uint64_t first_ns, last_ns;
    std::uint64_t offset, length, index_length;
    std::uint64_t packed, size;
  };

  void record(Op op, std::string_view content) { append(out_, op, content); }
  static void append(std::string& to, Op op, std::string_view content);
  std::uint64_t offset() const { return taken_ + out_.size(); }
  void summary(std::string& to) const;
  std::string statistics() const;
  std::string index_of(const Chunk& chunk) const;

  std::optional<Compressor> compressor_;
  std::string out_;
  std::uint64_t taken_ = 0;  ///< bytes that take() has given
  std::uint32_t crc_ = 0;    ///< checksum of the bytes that take() has given
  std::string schema_;       ///< contents of the records that the summary repeats
  std::string channel_;
  std::string metadata_name_;
  std::uint64_t metadata_offset_ = 0, metadata_length_ = 0;

  std::string messages_;  ///< records of the open chunk
  std::string index_;     ///< times and offsets of its messages
  std::uint64_t in_chunk_ = 0;
  std::uint64_t first_ns_ = 0, last_ns_ = 0;
  std::vector<Chunk> chunks_;
  std::uint64_t closed_ = 0;
};

}  // namespace smaservo::hal::mcap
