#include "hal/recording/mcap/reader.hpp"

#include <algorithm>
#include <cstring>
#include <fmt/format.h>

#include "hal/recording/mcap/compression.hpp"

namespace smaservo::hal::mcap {
namespace {

constexpr std::size_t piece = std::size_t{1} << 16U;
/// The largest record that is read as a whole, and the largest content of a chunk. Writers usually
/// make chunks of about 1 MiB.
constexpr std::uint64_t largest = std::uint64_t{64} << 20U;
constexpr std::uint64_t footer_size = 8 + 8 + 4;

/// Whether records of this kind are read; all others are skipped.
bool is_read(Op op) {
  switch (op) {
    case Op::header:
    case Op::footer:
    case Op::schema:
    case Op::channel:
    case Op::message:
    case Op::chunk:
    case Op::statistics:
    case Op::data_end:
      return true;
    default:
      return false;
  }
}

std::string_view name_of(Op op) {
  switch (op) {
    case Op::header:
      return "the header";
    case Op::footer:
      return "the footer";
    case Op::schema:
      return "a schema";
    case Op::channel:
      return "a channel";
    case Op::message:
      return "a message";
    case Op::chunk:
      return "a chunk";
    case Op::statistics:
      return "the statistics";
    case Op::data_end:
      return "the end of the data";
    default:
      return "a record of another kind";
  }
}

void expect_crc(std::uint64_t offset, std::string_view of, std::uint32_t stored,
                std::uint32_t computed) {
  // The writer stores 0 if it has computed no checksum.
  if (stored != 0 && stored != computed) {
    throw Malformed(offset, fmt::format("the checksum of {} is {:08X}h, computed is {:08X}h: the "
                                        "file is damaged",
                                        of, stored, computed));
  }
}

}  // namespace

Reader::Reader(Source source) : source_(std::move(source)) {
  if (!fill(magic.size()) || peek(magic.size()) != magic) {
    throw Malformed(0, "is no MCAP file: must begin with 89 4D 43 41 50 30 0D 0A");
  }
  consume(magic.size());
  Message none;
  record_ = offset_;
  if (!fill(1)) {
    end_early("before its header");
  } else if (static_cast<Op>(peek(1)[0]) != Op::header) {
    throw Malformed(offset_, "the first record must be the header");
  } else {
    next_record(none);
  }
}

bool Reader::next(Message& message) {
  while (part_ != Part::over) {
    if (in_chunk_ < chunk_.size() ? take_in_chunk(message) : next_record(message)) {
      ++messages_;
      return true;
    }
  }
  return false;
}

/// Makes sure that `size` bytes are in the buffer; false: the file has fewer. The buffer grows as
/// bytes come, not as a length promises.
bool Reader::fill(std::size_t size) {
  while (end_ - begin_ < size) {
    if (begin_ > 0) {
      std::memmove(buffer_.data(), buffer_.data() + begin_, end_ - begin_);
      end_ -= begin_;
      begin_ = 0;
    }
    if (buffer_.size() - end_ < piece) {
      buffer_.resize(std::max(2 * buffer_.size(), 2 * piece));
    }
    const std::size_t got = source_(buffer_.data() + end_, buffer_.size() - end_);
    if (got == 0) {
      return false;
    }
    end_ += got;
  }
  return true;
}

std::string_view Reader::peek(std::size_t size) const {
  return std::string_view(buffer_).substr(begin_, size);
}

void Reader::consume(std::size_t size) {
  crc_ = crc_of(peek(size), crc_);
  begin_ += size;
  offset_ += size;
}

bool Reader::skip(std::uint64_t size) {
  while (size > 0) {
    if (!fill(1)) {
      return false;
    }
    const auto part = static_cast<std::size_t>(std::min<std::uint64_t>(size, end_ - begin_));
    consume(part);
    size -= part;
  }
  return true;
}

void Reader::end_early(std::string_view how) {
  part_ = Part::over;
  cut_off_ = fmt::format("byte {}: the file ends {}: it was not finished, or is cut off",
                         offset_ + (end_ - begin_), how);
}

/// Reads a record of the file itself; true: it was a message.
bool Reader::next_record(Message& message) {
  record_ = offset_;
  if (!fill(record_head)) {
    end_early(end_ == begin_ ? "without a footer" : "within a record");
    return false;
  }
  Content head(peek(record_head), offset_, "the head of a record");
  const auto op = static_cast<Op>(head.number<std::uint8_t>());
  const auto length = head.number<std::uint64_t>();
  if (op == Op::none) {
    throw Malformed(offset_, "a record of kind 0, which there is not");
  }
  if (!is_read(op)) {
    consume(record_head);
    if (!skip(length)) {
      end_early("within a record");
    }
    return false;
  }
  if (length > largest) {
    throw Malformed(
        offset_, fmt::format("{} of {} bytes; at most {} are read", name_of(op), length, largest));
  }
  if (!fill(record_head + static_cast<std::size_t>(length))) {
    end_early(fmt::format("within {}", name_of(op)));
    return false;
  }
  return take_record(op, length, message);
}

bool Reader::take_record(Op op, std::uint64_t length, Message& message) {
  const auto size = record_head + static_cast<std::size_t>(length);
  // `content` points into the buffer, which does not change before the next record is read.
  const Content content(peek(size).substr(record_head), offset_ + record_head, name_of(op));
  if (op == Op::footer) {
    take_footer(content);
    return false;
  }
  if (op == Op::data_end) {
    take_data_end(content);
    begin_ += size;
    offset_ += size;
    summary_ = offset_;
    return false;
  }
  consume(size);
  if (part_ == Part::summary) {
    if (op == Op::statistics) {
      take_statistics(content);
    } else if (op != Op::schema && op != Op::channel) {
      throw Malformed(record_, fmt::format("{} behind the end of the data", name_of(op)));
    }
    return false;
  }
  if (op == Op::chunk) {
    open_chunk(content);
    return false;
  }
  if (op == Op::header) {
    take_header(content);
  }
  message.offset = record_;
  return take(op, content, message);
}

void Reader::take_header(Content content) const {
  if (record_ != magic.size()) {
    throw Malformed(record_, "a second header");
  }
  content.text();  // profile
  content.text();  // who has written it
}

/// Schemas, channels and messages, in a chunk or outside.
bool Reader::take(Op op, Content content, Message& message) {
  if (op == Op::schema) {
    take_schema(content);
  } else if (op == Op::channel) {
    take_channel(content);
  } else if (op == Op::message) {
    take_message(content, message);
    return true;
  }
  return false;
}

/// Reads the next record of the open chunk. Offsets are counted within the chunk's content.
bool Reader::take_in_chunk(Message& message) {
  try {
    Content rest(std::string_view(chunk_).substr(in_chunk_), in_chunk_, "the chunk");
    const auto op = static_cast<Op>(rest.number<std::uint8_t>());
    const auto length = rest.number<std::uint64_t>();
    const Content content(rest.take(length), in_chunk_ + record_head, name_of(op));
    if (op == Op::none ||
        (is_read(op) && op != Op::schema && op != Op::channel && op != Op::message)) {
      throw Malformed(in_chunk_, fmt::format("{} cannot be in a chunk", name_of(op)));
    }
    message.offset = record_;
    const bool found = take(op, content, message);
    in_chunk_ += record_head + static_cast<std::size_t>(length);
    return found;
  } catch (const Malformed& problem) {
    throw Malformed(record_, fmt::format("in this chunk's content, {}", problem.what()));
  }
}

void Reader::take_schema(Content content) {
  const auto id = content.number<std::uint16_t>();
  Schema schema;
  schema.name = content.text();
  schema.encoding = content.text();
  schema.data = content.text();
  // The number 0 belongs to no schema and is to be ignored.
  if (id != 0 && schemas_.try_emplace(id, schema).first->second != schema) {
    throw Malformed(content.offset(), fmt::format("schema {} is another one than before", id));
  }
}

void Reader::take_channel(Content content) {
  const auto id = content.number<std::uint16_t>();
  Channel channel;
  channel.schema = content.number<std::uint16_t>();
  channel.topic = content.text();
  channel.encoding = content.text();
  channel.metadata = content.text();
  if (channel.schema != 0 && !schemas_.contains(channel.schema)) {
    throw Malformed(content.offset(), fmt::format("channel {} has schema {}, which is not in the "
                                                  "file before it",
                                                  id, channel.schema));
  }
  if (channels_.try_emplace(id, channel).first->second != channel) {
    throw Malformed(content.offset(), fmt::format("channel {} is another one than before", id));
  }
}

void Reader::take_message(Content content, Message& message) {
  message.channel = content.number<std::uint16_t>();
  content.number<std::uint32_t>();  // sequence
  message.log_time_ns = content.number<std::uint64_t>();
  content.number<std::uint64_t>();  // publish time
  message.data = content.rest();
  if (!channels_.contains(message.channel)) {
    throw Malformed(content.offset(), fmt::format("a message of channel {}, which is not in the "
                                                  "file before it",
                                                  message.channel));
  }
}

void Reader::open_chunk(Content content) {
  content.take(8 + 8);  // first and last time
  const auto size = content.number<std::uint64_t>();
  const auto crc = content.number<std::uint32_t>();
  const std::string_view compression = content.text();
  const auto packed = content.number<std::uint64_t>();
  if (packed != content.rest().size()) {
    throw Malformed(content.offset(), fmt::format("a chunk of {} bytes says that it has {}",
                                                  content.rest().size(), packed));
  }
  if (size > largest) {
    throw Malformed(record_,
                    fmt::format("a chunk of {} bytes; at most {} are read", size, largest));
  }
  in_chunk_ = 0;
  if (compression.empty()) {
    if (packed != size) {
      throw Malformed(record_, fmt::format("a chunk without compression has {} bytes where it "
                                           "should have {}",
                                           packed, size));
    }
    chunk_ = content.rest();
  } else if (const std::string problem = decompress(compression, content.rest(), size, chunk_);
             !problem.empty()) {
    throw Malformed(record_, "a chunk: " + problem);
  }
  expect_crc(record_, "a chunk", crc, crc_of(chunk_));
}

void Reader::take_data_end(Content content) {
  if (part_ != Part::data) {
    throw Malformed(record_, "the end of the data for the second time");
  }
  expect_crc(record_, "the data", content.number<std::uint32_t>(), crc_);
  crc_ = 0;
  part_ = Part::summary;
}

void Reader::take_statistics(Content content) const {
  const auto count = content.number<std::uint64_t>();
  if (count != messages_) {
    throw Malformed(
        record_, fmt::format("the statistics say {} messages, the file has {}", count, messages_));
  }
}

void Reader::take_footer(Content content) {
  const auto start = content.number<std::uint64_t>();
  content.number<std::uint64_t>();  // summary offsets
  consume(record_head + footer_size - sizeof(std::uint32_t));
  const auto crc = content.number<std::uint32_t>();
  if (start != 0) {
    if (part_ != Part::summary || start != summary_) {
      throw Malformed(record_, fmt::format("the footer says that the summary begins at byte {}; "
                                           "the data end at byte {}",
                                           start, part_ == Part::summary ? summary_ : record_));
    }
    expect_crc(record_, "the summary", crc, crc_);
  }
  consume(sizeof(crc) + content.rest().size());
  if (!fill(magic.size())) {
    end_early("without the magic bytes at its end");
    return;
  }
  if (peek(magic.size()) != magic) {
    throw Malformed(offset_, "must end with 89 4D 43 41 50 30 0D 0A");
  }
  consume(magic.size());
  if (fill(1)) {
    throw Malformed(offset_, "the file goes on behind its end");
  }
  part_ = Part::over;
}

}  // namespace smaservo::hal::mcap
