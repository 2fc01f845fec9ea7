#pragma once
// Reads the messages of any MCAP file in one pass, from a pipe as well; checks what the file says
// about itself: lengths, checksums, statistics.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <string_view>

#include "hal/recording/mcap/records.hpp"

namespace smaservo::hal::mcap {

struct Schema {
  std::string name, encoding, data;
  bool operator==(const Schema&) const = default;
};
struct Channel {
  std::uint16_t schema = 0;  ///< 0: it has none
  std::string topic, encoding;
  std::string metadata;  ///< the map's bytes as the file has them
  bool operator==(const Channel&) const = default;
};

struct Message {
  std::uint16_t channel = 0;
  std::uint64_t log_time_ns = 0;
  std::string_view data;  ///< valid until the next message
  /// Position in the file of the message's record, or of the chunk that contains it.
  std::uint64_t offset = 0;
};

class Reader {
 public:
  /// Gives up to `size` bytes; 0 at the end. May throw.
  using Source = std::function<std::size_t(char* to, std::size_t size)>;
  /// Reads the header. Throws Malformed.
  explicit Reader(Source source);

  /// Reads the next message; false at the end. Throws Malformed.
  bool next(Message& message);

  /// For a file that was not finished: where it ends; everything before is complete. Empty: it was
  /// finished.
  const std::string& cut_off() const { return cut_off_; }
  /// The channels that have been read up to the present message.
  const std::map<std::uint16_t, Channel>& channels() const { return channels_; }
  const std::map<std::uint16_t, Schema>& schemas() const { return schemas_; }

 private:
  enum class Part : std::uint8_t { data, summary, over };

  bool fill(std::size_t size);
  std::string_view peek(std::size_t size) const;
  void consume(std::size_t size);
  bool skip(std::uint64_t size);

  bool next_record(Message& message);
  bool take_record(Op op, std::uint64_t length, Message& message);
  bool take_in_chunk(Message& message);
  bool take(Op op, Content content, Message& message);
  void take_header(Content content) const;
  void take_schema(Content content);
  void take_channel(Content content);
  void take_message(Content content, Message& message);
  void open_chunk(Content content);
  void take_data_end(Content content);
  void take_statistics(Content content) const;
  void take_footer(Content content);
  void end_early(std::string_view how);

  Source source_;
  std::string buffer_;
  std::size_t begin_ = 0, end_ = 0;  ///< unread bytes in the buffer
  std::uint64_t offset_ = 0;         ///< position in the file of the first unread byte
  std::uint64_t record_ = 0;         ///< position in the file of the present record
  std::uint32_t crc_ = 0;            ///< checksum of the data section so far, later of the summary
  Part part_ = Part::data;
  std::uint64_t summary_ = 0;  ///< position in the file where the summary begins
  std::string chunk_;
  std::size_t in_chunk_ = 0;  ///< bytes of `chunk_` that have been read
  std::uint64_t messages_ = 0;
  std::map<std::uint16_t, Schema> schemas_;
  std::map<std::uint16_t, Channel> channels_;
  std::string cut_off_;
};

}  // namespace smaservo::hal::mcap
