#include "firmware/canopen/node/sdo_server.hpp"

#include <algorithm>

namespace smaservo::canopen {
namespace {

// Command specifiers: the three highest bits of a request.
constexpr unsigned download_segment = 0;
constexpr unsigned download = 1;
constexpr unsigned upload = 2;
constexpr unsigned upload_segment = 3;
constexpr unsigned abort_transfer = 4;
constexpr unsigned block_upload = 5;
constexpr unsigned block_download = 6;

constexpr std::uint8_t max_block = 127;

unsigned specifier(std::uint8_t command) {
  return command >> 5U;
}

/// Whether these bytes may be the first request of an expedited or segmented transfer of an object
/// that the dictionary has.
bool may_begin(const Dictionary& dictionary, std::span<const std::uint8_t, 8> request) {
  const Key key{static_cast<std::uint16_t>(take_number(request.subspan(1, 2))), request[3]};
  const unsigned cs = specifier(request[0]);
  Entry entry{};
  return (cs == download || request[0] == upload << 5U) &&
         dictionary.find(key, entry) == Abort::none;
}

}  // namespace

void SdoServer::receive(Request request, std::uint64_t now_us) {
  last_us_ = now_us;
  const unsigned cs = specifier(request[0]);
  // Within a block the first byte is a sequence number, except for an abort.
  const unsigned number = request[0] & 0x7FU;
  // Sequence numbers rise within a block. A number that has passed and comes after a pause cannot
  // be from the client that sends the block: if the bytes can be read as the beginning of a
  // transfer, the block is abandoned. A segment that is merely repeated does not abandon it.
  constexpr std::uint64_t pause_us = 50'000;
  const bool has_passed =
      number <= highest_ && number != sequence_ && number != sequence_ + 1U && number != 0;
  const bool abandoned =
      has_passed && pause_us <= now_us - waits_since_us_ && may_begin(dictionary_, request);
  if (state_ == State::block_download && request[0] != 0x80 && !abandoned) {
    receive_block(request, now_us);
    return;
  }
  waits_since_us_ = now_us;
  switch (cs) {
    case download_segment:
      continue_download(request);
      break;
    case download:
      start_download(request);
      break;
    case upload:
      start_upload(request);
      break;
    case upload_segment:
      continue_upload(request);
      break;
    case abort_transfer:
      reset();
      break;
    case block_upload:
      receive_block_upload(request);
      break;
    case block_download:
      receive_block_download(request);
      break;
    default:
      abort(Abort::command);
      break;
  }
}

void SdoServer::advance(std::uint64_t now_us) {
  if (sent_) {  // a block may take long on a slow bus: the client's time-out starts when the block
                // has been sent
    sent_ = false;
    waits_since_us_ = now_us;
  }
  const bool waits =
      state_ != State::idle && state_ != State::pending && state_ != State::block_upload;
  const std::uint64_t timeout_us =
      state_ == State::block_download ? timeouts_.segment_us : timeouts_.client_us;
  if (waits && timeout_us < now_us - waits_since_us_) {
    abort(Abort::timeout);
  }
}

bool SdoServer::take(std::span<std::uint8_t, 8> answer) {
  if (answer_waits_) {
    std::ranges::copy(answer_, answer.begin());
    answer_waits_ = false;
    return true;
  }
  if (state_ != State::block_upload) {
    return false;
  }
  segment_of_block(answer);
  return true;
}

void SdoServer::finish(Abort result) {
  if (state_ != State::pending) {
    return;
  }
  state_ = State::idle;
  if (result == Abort::none) {
    keyed(0x60);
  } else {
    abort(result);
  }
}

void SdoServer::reset() {
  state_ = State::idle;
  answer_waits_ = false;
}

// Finding, reading, writing.

/// Finds the object of a new request, which ends any transfer in progress.
bool SdoServer::find(Request request) {
  reset();
  key_ = {static_cast<std::uint16_t>(take_number(request.subspan(1, 2))), request[3]};
  const Abort found = dictionary_.find(key_, entry_);
  if (found != Abort::none) {
    abort(found);
  }
  return found == Abort::none;
}

bool SdoServer::find_readable(Request request) {
  if (!find(request)) {
    return false;
  }
  const bool may = (entry_.access & readable) != 0;
  if (!may) {
    abort(Abort::write_only);
  }
  return may;
}

bool SdoServer::find_writable(Request request, Data known) {
  if (!find(request)) {
    return false;
  }
  const bool may = (entry_.access & writable) != 0;
  if (!may) {
    refuse(Abort::read_only, known);
  }
  return may;
}

/// Aborts a download whose object is known, and informs the dictionary.
void SdoServer::refuse(Abort code, Data known) {
  dictionary_.refused(entry_, known, code);
  abort(code);
}

/// Whether a value of `size` bytes fits the object's type; if not, the download is refused.
bool SdoServer::fits(std::uint32_t size, Data known) {
  const std::uint32_t wanted = size_of(entry_.type);
  Abort wrong = Abort::none;
  if (wanted == 0) {
    wrong = buffer_.size() < size ? Abort::memory : Abort::none;
  } else if (size != wanted) {
    wrong = size < wanted ? Abort::too_short : Abort::too_long;
  }
  if (wrong != Abort::none) {
    refuse(wrong, known);
  }
  return wrong == Abort::none;
}

/// A value that fits into the buffer is read at once, since it may change during the transfer.
bool SdoServer::open_upload() {
  size_ = entry_.size;
  offset_ = 0;
  snapshot_ = false;
  if (size_ <= buffer_.size()) {
    if (!fetch(0, buffer_.first(size_))) {
      return false;
    }
    snapshot_ = true;
  }
  return true;
}

bool SdoServer::fetch(std::uint32_t offset, std::span<std::uint8_t> to) {
  if (snapshot_) {
    std::ranges::copy(buffer_.subspan(offset, to.size()), to.begin());
    return true;
  }
  const Abort result = dictionary_.read(entry_, offset, to);
  if (result != Abort::none) {
    abort(result);
  }
  return result == Abort::none;
}

/// Writes a value. Returns whether the confirmation may be sent now.
bool SdoServer::store(Data data) {
  const Abort result = dictionary_.write(entry_, data, Source::sdo);
  state_ = result == Abort::pending ? State::pending : State::idle;
  if (result != Abort::none && result != Abort::pending) {
    abort(result);
  }
  return result == Abort::none;
}

std::span<std::uint8_t, 8> SdoServer::answer(std::uint8_t command) {
  answer_ = {command};
  answer_waits_ = true;
  return answer_;
}

/// Begins an answer that names the object.
void SdoServer::keyed(std::uint8_t command) {
  const auto to = answer(command);
  put_number(to.subspan(1, 2), key_.index);
  to[3] = key_.sub;
}

void SdoServer::abort(Abort code) {
  state_ = State::idle;
  keyed(0x80);
  put_number(std::span(answer_).subspan(4), static_cast<std::uint32_t>(code));
}

// Expedited and segmented transfers.

void SdoServer::start_download(Request request) {
  const bool expedited = (request[0] & 2U) != 0;
  const bool sized = (request[0] & 1U) != 0;
  const std::uint32_t sent = !expedited ? 0 : sized ? 4U - (request[0] >> 2U & 3U) : 4;
  const Data known = Data(request).subspan(4, sent);
  if (!find_writable(request, known)) {
    return;
  }
  if (expedited) {
    const std::uint32_t wanted = size_of(entry_.type);
    const std::uint32_t unsized = wanted == 0 || wanted > 4 ? 4 : wanted;
    const std::uint32_t size = sized ? sent : unsized;
    if (fits(size, known) && store(request.subspan(4, size))) {
      keyed(0x60);
    }
    return;
  }
  size_ = sized ? static_cast<std::uint32_t>(take_number(request.subspan(4))) : 0;
  if (sized && !fits(size_, {})) {
    return;
  }
  offset_ = 0;
  toggle_ = false;
  state_ = State::download;
  keyed(0x60);
}

void SdoServer::continue_download(Request request) {
  if (state_ != State::download) {
    abort(Abort::command);
    return;
  }
  if (((request[0] & 0x10U) != 0) != toggle_) {
    abort(Abort::toggle);
    return;
  }
  const std::uint32_t size = 7U - (request[0] >> 1U & 7U);
  const bool last = (request[0] & 1U) != 0;
  const std::uint32_t room =
      size_of(entry_.type) != 0 ? size_of(entry_.type) : static_cast<std::uint32_t>(buffer_.size());
  const std::uint32_t max = size_ != 0 ? size_ : room;
  if (max < offset_ + size) {
    refuse(size_of(entry_.type) == 0 && size_ == 0 ? Abort::memory : Abort::too_long,
           buffer_.first(offset_));
    return;
  }
  std::ranges::copy(request.subspan(1, size), buffer_.subspan(offset_).begin());
  offset_ += size;
  if (last) {
    const Data known = buffer_.first(offset_);
    if (size_ != 0 && offset_ < size_) {
      refuse(Abort::too_short, known);
      return;
    }
    if (!fits(offset_, known)) {
      return;
    }
  }
  const auto command = static_cast<std::uint8_t>(toggle_ ? 0x30 : 0x20);
  toggle_ = !toggle_;
  if (!last || store(buffer_.first(offset_))) {
    answer(command);
  }
}

void SdoServer::start_upload(Request request) {
  if (find_readable(request) && open_upload()) {
    answer_upload();
  }
}

void SdoServer::answer_upload() {
  if (1 <= size_ && size_ <= 4) {
    keyed(static_cast<std::uint8_t>(0x43U | (4U - size_) << 2U));
    if (fetch(0, std::span(answer_).subspan(4, size_))) {
      state_ = State::idle;
    }
    return;
  }
  keyed(0x41);
  put_number(std::span(answer_).subspan(4), size_);
  toggle_ = false;
  state_ = State::upload;
}

void SdoServer::continue_upload(Request request) {
  if (state_ != State::upload) {
    abort(Abort::command);
    return;
  }
  if (((request[0] & 0x10U) != 0) != toggle_) {
    abort(Abort::toggle);
    return;
  }
  const std::uint32_t size = std::min<std::uint32_t>(7, size_ - offset_);
  const bool last = offset_ + size == size_;
  const auto to = answer(
      static_cast<std::uint8_t>((toggle_ ? 0x10U : 0U) | (7U - size) << 1U | (last ? 1U : 0U)));
  if (!fetch(offset_, to.subspan(1, size))) {
    return;
  }
  offset_ += size;
  toggle_ = !toggle_;
  state_ = last ? State::idle : State::upload;
}

// Block download.

void SdoServer::receive_block_download(Request request) {
  if ((request[0] & 1U) != 0) {
    end_block_download(request);
    return;
  }
  if (!find_writable(request, {})) {
    return;
  }
  with_crc_ = (request[0] & 4U) != 0;
  const bool sized = (request[0] & 2U) != 0;
  size_ = sized ? static_cast<std::uint32_t>(take_number(request.subspan(4))) : 0;
  if (sized && !fits(size_, {})) {
    return;
  }
  offset_ = 0;
  sequence_ = highest_ = 0;
  state_ = State::block_download;
  keyed(0xA4);
  answer_[4] = block_size_ = max_block;
}

/// Drops a segment that does not follow the last one; the acknowledgement of the block tells the
/// client. A rising number shows that the client continues after a lost segment, and restarts its
/// time-out. Other numbers do not: they may be requests of a client that polls, after the client
/// that began the block has gone.
void SdoServer::receive_block(Request request, std::uint64_t now_us) {
  const auto number = static_cast<std::uint8_t>(request[0] & 0x7FU);
  const bool last = (request[0] & 0x80U) != 0;
  if (number == 0 || block_size_ < number) {
    abort(Abort::sequence);
    return;
  }
  const bool follows = number == sequence_ + 1;
  if (follows || highest_ < number) {
    highest_ = number;
    waits_since_us_ = now_us;
  }
  if (follows) {
    sequence_ = number;
    // The last segment may be padded beyond the end of the buffer.
    const auto room = static_cast<std::uint32_t>(buffer_.size()) - offset_;
    const std::uint32_t size = std::min<std::uint32_t>(7, room);
    if (room < 7 && !last) {
      refuse(size_of(entry_.type) == 0 ? Abort::memory : Abort::too_long, buffer_.first(offset_));
      return;
    }
    std::ranges::copy(request.subspan(1, size), buffer_.subspan(offset_).begin());
    offset_ += 7;
  }
  if (!last && number != block_size_) {
    return;
  }
  if (last && follows) {
    state_ = State::block_download_end;
  }
  const auto to = answer(0xA2);
  to[1] = sequence_;
  to[2] = block_size_ = max_block;
  if (sequence_ != 0) {
    highest_ = 0;
  }
  sequence_ = 0;
}

void SdoServer::end_block_download(Request request) {
  if (state_ != State::block_download_end) {
    abort(Abort::command);
    return;
  }
  const std::uint32_t unused = request[0] >> 2U & 7U;
  const std::uint32_t size = offset_ - std::min(unused, offset_);
  const Data data = buffer_.first(std::min<std::size_t>(size, buffer_.size()));
  if (size_ != 0 && size != size_) {
    refuse(size < size_ ? Abort::too_short : Abort::too_long, data);
    return;
  }
  if (!fits(size, data)) {
    return;
  }
  if (with_crc_ && crc16(data) != take_number(request.subspan(1, 2))) {
    refuse(Abort::crc, data);
    return;
  }
  if (store(data)) {
    answer(0xA1);
  }
}

// Block upload.

void SdoServer::start_block_upload(Request request) {
  if (!find_readable(request)) {
    return;
  }
  block_size_ = request[4];
  if (block_size_ == 0 || max_block < block_size_) {
    abort(Abort::block_size);
    return;
  }
  if (!open_upload()) {
    return;
  }
  // 0: the client does not allow a change to another transfer protocol.
  const std::uint32_t threshold = request[5];
  if (threshold != 0 && size_ <= threshold) {
    answer_upload();
    return;
  }
  with_crc_ = (request[0] & 4U) != 0;
  crc_ = 0;
  crc_end_ = 0;
  keyed(0xC6);
  put_number(std::span(answer_).subspan(4), size_);
  state_ = State::block_upload_start;
}

void SdoServer::receive_block_upload(Request request) {
  switch (request[0] & 3U) {
    case 0:
      start_block_upload(request);
      return;
    case 1:
      if (state_ == State::block_upload_end) {
        state_ = State::idle;
        return;
      }
      break;
    case 2:
      if (state_ == State::block_upload_ack || state_ == State::block_upload) {
        acknowledge_block(request);
        return;
      }
      break;
    default:
      if (state_ == State::block_upload_start) {
        sequence_ = 0;
        state_ = State::block_upload;
        return;
      }
      break;
  }
  abort(Abort::command);
}

void SdoServer::segment_of_block(std::span<std::uint8_t, 8> to) {
  const std::uint32_t at = offset_ + 7U * sequence_;
  const std::uint32_t size = std::min<std::uint32_t>(7, size_ - at);
  std::ranges::fill(to, std::uint8_t{0});
  if (!fetch(at, to.subspan(1, size))) {
    answer_waits_ = false;
    std::ranges::copy(answer_, to.begin());
    return;
  }
  if (crc_end_ == at) {
    crc_ = crc16(to.subspan(1, size), crc_);
    crc_end_ = at + size;
  }
  ++sequence_;
  const bool last = at + size == size_;
  to[0] = static_cast<std::uint8_t>(sequence_ | (last ? 0x80U : 0U));
  if (last || sequence_ == block_size_) {
    state_ = State::block_upload_ack;
    sent_ = true;
  }
}

/// Segments that the client has not received are sent again in the next block.
void SdoServer::acknowledge_block(Request request) {
  const std::uint8_t good = request[1];
  if (sequence_ < good) {
    abort(Abort::sequence);
    return;
  }
  if (request[2] == 0 || max_block < request[2]) {
    abort(Abort::block_size);
    return;
  }
  const std::uint32_t before = offset_;
  offset_ = std::min(size_, offset_ + 7U * good);
  block_size_ = request[2];
  const std::uint32_t last = size_ - before - 7U * (good == 0 ? 0U : good - 1U);
  sequence_ = 0;
  if (offset_ < size_ || good == 0) {
    state_ = State::block_upload;
    return;
  }
  state_ = State::block_upload_end;
  const auto to =
      answer(static_cast<std::uint8_t>(0xC1U | (7U - std::min<std::uint32_t>(7, last)) << 2U));
  if (with_crc_) {
    put_number(to.subspan(1, 2), crc_);
  }
}

}  // namespace smaservo::canopen
