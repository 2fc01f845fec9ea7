#include "hal/recording/mcap/writer.hpp"

#include <algorithm>

namespace smaservo::hal::mcap {
namespace {

constexpr std::uint16_t only_schema = 1;
constexpr std::uint16_t only_channel = 1;
/// A chunk is closed when its messages have this many bytes, as in Foxglove's own writers.
constexpr std::size_t chunk_size = std::size_t{1} << 20U;

void put_map(std::string& to, const Texts& entries) {
  std::string map;
  for (const auto& [key, value] : entries) {
    put_text(map, key);
    put_text(map, value);
  }
  put_text(to, map);
}

}  // namespace

Writer::Writer(std::string_view library, bool compressed) {
  if (compressed) {
    compressor_.emplace();
  }
  out_ = magic;
  std::string content;
  put_text(content, "");  // no profile
  put_text(content, library);
  record(Op::header, content);
}

void Writer::append(std::string& to, Op op, std::string_view content) {
  to += static_cast<char>(op);
  put(to, std::uint64_t{content.size()});
  to += content;
}

void Writer::metadata(std::string_view name, const Texts& entries) {
  std::string content;
  put_text(content, name);
  put_map(content, entries);
  metadata_name_ = name;
  metadata_offset_ = offset();
  metadata_length_ = record_head + content.size();
  record(Op::metadata, content);
}

void Writer::stream(const Stream& stream) {
  put(schema_, only_schema);
  put_text(schema_, stream.schema_name);
  put_text(schema_, "jsonschema");
  put_text(schema_, stream.schema);
  put(channel_, only_channel);
  put(channel_, only_schema);
  put_text(channel_, stream.topic);
  put_text(channel_, "json");
  put_map(channel_, {});
  record(Op::schema, schema_);
  record(Op::channel, channel_);
}

void Writer::message(std::uint64_t time_ns, std::string_view data) {
  first_ns_ = in_chunk_ == 0 ? time_ns : std::min(first_ns_, time_ns);
  last_ns_ = in_chunk_ == 0 ? time_ns : std::max(last_ns_, time_ns);
  put(index_, time_ns);
  put(index_, std::uint64_t{messages_.size()});
  constexpr std::size_t head = 2 + 4 + 8 + 8;
  messages_ += static_cast<char>(Op::message);
  put(messages_, std::uint64_t{head + data.size()});
  put(messages_, only_channel);
  put(messages_, static_cast<std::uint32_t>(closed_ + in_chunk_));
  put(messages_, time_ns);
  put(messages_, time_ns);
  messages_ += data;
  ++in_chunk_;
  if (messages_.size() >= chunk_size) {
    close_chunk();
  }
}

void Writer::close_chunk() {
  if (in_chunk_ == 0) {
    return;
  }
  const std::string_view packed = compressor_ ? compressor_->compress(messages_) : messages_;
  Chunk chunk{first_ns_, last_ns_, offset(), 0, 0, packed.size(), messages_.size()};
  std::string head;
  put(head, first_ns_);
  put(head, last_ns_);
  put(head, std::uint64_t{messages_.size()});
  put(head, crc_of(messages_));
  put_text(head, compressor_ ? zstd : "");
  put(head, std::uint64_t{packed.size()});
  out_ += static_cast<char>(Op::chunk);
  put(out_, std::uint64_t{head.size() + packed.size()});
  out_ += head;
  out_ += packed;
  chunk.length = offset() - chunk.offset;
  std::string index;
  put(index, only_channel);
  put_text(index, index_);
  record(Op::message_index, index);
  chunk.index_length = record_head + index.size();
  chunks_.push_back(chunk);
  closed_ += in_chunk_;
  in_chunk_ = 0;
  messages_.clear();
  index_.clear();
}

void Writer::finish() {
  close_chunk();
  std::string content;
  put(content, crc_of(out_, crc_));
  record(Op::data_end, content);
  const std::uint64_t start = offset();
  std::string end;
  summary(end);
  const std::uint64_t offsets = start + end.size();
  // The summary's records are grouped by kind, and each group is listed here in the order of the
  // summary.
  std::string groups;
  for (std::size_t at = 0; at < end.size();) {
    const char op = end[at];
    std::size_t stop = at;
    while (stop < end.size() && end[stop] == op) {
      Content head(std::string_view(end).substr(stop + 1), 0, "summary");
      stop += record_head + static_cast<std::size_t>(head.number<std::uint64_t>());
    }
    std::string group{op};
    put(group, start + at);
    put(group, std::uint64_t{stop - at});
    append(groups, Op::summary_offset, group);
    at = stop;
  }
  end += groups;
  end += static_cast<char>(Op::footer);
  put(end, std::uint64_t{8 + 8 + 4});
  put(end, start);
  put(end, groups.empty() ? std::uint64_t{0} : offsets);
  put(end, crc_of(end));
  out_ += end;
  out_ += magic;
}

void Writer::summary(std::string& to) const {
  if (!channel_.empty()) {
    append(to, Op::schema, schema_);
    append(to, Op::channel, channel_);
  }
  append(to, Op::statistics, statistics());
  for (const Chunk& chunk : chunks_) {
    append(to, Op::chunk_index, index_of(chunk));
  }
  if (metadata_length_ > 0) {
    std::string content;
    put(content, metadata_offset_);
    put(content, metadata_length_);
    put_text(content, metadata_name_);
    append(to, Op::metadata_index, content);
  }
}

std::string Writer::statistics() const {
  std::string content;
  const bool known = !channel_.empty();
  put(content, closed_);
  put(content, std::uint16_t{known});
  put(content, std::uint32_t{known});
  put(content, std::uint32_t{0});  // attachments
  put(content, std::uint32_t{metadata_length_ > 0});
  put(content, static_cast<std::uint32_t>(chunks_.size()));
  std::uint64_t first = chunks_.empty() ? 0 : chunks_.front().first_ns;
  std::uint64_t last = 0;
  for (const Chunk& chunk : chunks_) {
    first = std::min(first, chunk.first_ns);
    last = std::max(last, chunk.last_ns);
  }
  put(content, first);
  put(content, last);
  std::string counts;
  if (known) {
    put(counts, only_channel);
    put(counts, closed_);
  }
  put_text(content, counts);
  return content;
}

std::string Writer::index_of(const Chunk& chunk) const {
  std::string content;
  put(content, chunk.first_ns);
  put(content, chunk.last_ns);
  put(content, chunk.offset);
  put(content, chunk.length);
  std::string offsets;
  put(offsets, only_channel);
  put(offsets, chunk.offset + chunk.length);
  put_text(content, offsets);
  put(content, chunk.index_length);
  put_text(content, compressor_ ? zstd : "");
  put(content, chunk.packed);
  put(content, chunk.size);
  return content;
}

std::string Writer::take() {
  crc_ = crc_of(out_, crc_);
  taken_ += out_.size();
  return std::exchange(out_, {});
}

}  // namespace smaservo::hal::mcap
