#pragma once
// SDO server of CiA 301: expedited, segmented and block transfers, one at a time.
//
// Frames go in by receive(), and answers are made when take() asks for them: so a block upload
// needs no queue. A value that is longer than the buffer is read in pieces and cannot be written.
// Cost: one object access and at most 8 bytes of CRC per call; the end of a block download adds the
// CRC over the whole buffer.

#include "firmware/canopen/node/object.hpp"
#include "hal/can_frame.hpp"

namespace smaservo::canopen {

/// The silence of a client after which its transfer is ended with Abort::timeout.
struct SdoTimeouts {
  /// Between two segments of a block download. Until it has passed, the server takes any request as
  /// a segment, so that no other client is answered.
  std::uint64_t segment_us = 1'000'000;
  /// In all other cases, while the next request of the client or its acknowledgement of a block is
  /// due. It keeps no other client waiting: a new request ends the old transfer.
  std::uint64_t client_us = 5'000'000;
};

class SdoServer {
 public:
  SdoServer(Dictionary& dictionary, std::span<std::uint8_t> buffer)
      : dictionary_(dictionary), buffer_(buffer) {}

  /// Handles the 8 bytes of a request.
  void receive(std::span<const std::uint8_t, 8> request, std::uint64_t now_us);
  void advance(std::uint64_t now_us);
  /// Gives the 8 bytes of the next answer; false if there is none.
  bool take(std::span<std::uint8_t, 8> answer);
  /// Answers a write that returned Abort::pending; does nothing if there is none.
  void finish(Abort result);
  /// Drops the transfer in progress.
  void reset();
  /// Takes effect at once, also for a transfer in progress.
  void set_timeouts(const SdoTimeouts& timeouts) { timeouts_ = timeouts; }

  /// The time at which the last request came.
  std::uint64_t last_request_us() const { return last_us_; }

 private:
  enum class State : std::uint8_t {
    idle,
    pending,
    download,
    upload,
    block_download,      ///< a block is being received
    block_download_end,  ///< all blocks have been received
    block_upload_start,  ///< the request is answered; the client has to start the upload
    block_upload,        ///< a block is being sent
    block_upload_ack,    ///< a block has been sent and has to be acknowledged
    block_upload_end,    ///< all blocks are acknowledged
  };

  using Request = std::span<const std::uint8_t, 8>;
  using Data = std::span<const std::uint8_t>;
  void start_download(Request request);
  void start_upload(Request request);
  void continue_download(Request request);
  void continue_upload(Request request);
  void receive_block_download(Request request);
  void receive_block(Request request, std::uint64_t now_us);
  void end_block_download(Request request);
  void start_block_upload(Request request);
  void receive_block_upload(Request request);
  void acknowledge_block(Request request);

  bool find(Request request);
  bool find_readable(Request request);
  bool find_writable(Request request, Data known);
  bool fits(std::uint32_t size, Data known);
  void refuse(Abort code, Data known);
  bool open_upload();
  void answer_upload();
  bool store(Data data);
  bool fetch(std::uint32_t offset, std::span<std::uint8_t> to);
  void segment_of_block(std::span<std::uint8_t, 8> to);
  void abort(Abort code);
  std::span<std::uint8_t, 8> answer(std::uint8_t command);
  void keyed(std::uint8_t command);

  Dictionary& dictionary_;
  std::span<std::uint8_t> buffer_;
  SdoTimeouts timeouts_;
  std::uint64_t last_us_ = 0, waits_since_us_ = 0;
  Entry entry_{};
  /// Bytes of an upload; of a download the announced number, 0 if none was announced.
  std::uint32_t size_ = 0;
  std::uint32_t offset_ = 0;   ///< bytes transferred and acknowledged
  std::uint32_t crc_end_ = 0;  ///< crc_ is computed up to this offset
  Key key_{};
  std::uint16_t crc_ = 0;
  State state_ = State::idle;
  std::uint8_t block_size_ = 127;
  std::uint8_t sequence_ = 0;
  /// Highest number seen in a block download since the last segment that was accepted.
  std::uint8_t highest_ = 0;
  bool toggle_ = false;
  bool snapshot_ = false;  ///< the whole value of the upload is in the buffer
  bool with_crc_ = false;
  bool answer_waits_ = false;
  bool sent_ = false;  ///< the last segment of a block has just been taken
  std::array<std::uint8_t, 8> answer_{};
};

}  // namespace smaservo::canopen
