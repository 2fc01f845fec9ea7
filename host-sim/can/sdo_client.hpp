#pragma once
// Reads and writes objects of a node by SDO transfers of CiA 301, of all kinds.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "firmware/parameters/key.hpp"
#include "host-sim/can/bus/bus.hpp"
#include "model/files/error.hpp"

namespace smaservo::can {

using Bytes = std::vector<std::uint8_t>;

/// A transfer that the node refused or did not answer.
class SdoError : public files::UserError {
 public:
  SdoError(const std::string& text, std::uint32_t code) : files::UserError(text), code_(code) {}

  /// The abort code; 0 if there was no answer.
  std::uint32_t code() const { return code_; }

 private:
  std::uint32_t code_;
};

/// The text of a key, such as "2100h:1".
std::string key_text(Key key);

/// All functions throw SdoError, also for a node that would occupy them for ever: one that sends
/// without end, or sends nothing new again and again. A node has one SDO server, which answers the
/// later of two requests that collide with those of another client, and a frame may be lost. So a
/// read without an answer is repeated once, a write only where the caller says that it may be.
class SdoClient {
 public:
  static constexpr std::int64_t usual_timeout_us = 500'000;
  /// Time-out for writes that the node answers only after it has stored the values.
  static constexpr std::int64_t store_timeout_us = 10'000'000;

  /// `node` is 1 to 127.
  SdoClient(Bus& bus, unsigned node) : bus_(bus), node_(node) {}

  unsigned node() const { return node_; }
  Bus& bus() { return bus_; }
  std::int64_t timeout_us() const { return timeout_us_; }
  void set_timeout(std::int64_t microseconds) { timeout_us_ = microseconds; }

  /// Reads by an expedited or segmented transfer, as the node chooses.
  Bytes upload(Key key);
  /// Writes up to four bytes by an expedited transfer, otherwise by a segmented one.
  void download(Key key, std::span<const std::uint8_t> value) { write(key, value, 1); }
  /// As download(), but an expedited transfer without an answer is repeated once. Only for what may
  /// be executed twice: the first request may have been carried out, and its answer lost.
  void download_again(Key key, std::span<const std::uint8_t> value) { write(key, value, 2); }
  /// Writes by a segmented transfer, whatever the length.
  void download_segmented(Key key, std::span<const std::uint8_t> value);
  Bytes upload_block(Key key);
  void download_block(Key key, std::span<const std::uint8_t> value);

 private:
  using Data = std::array<std::uint8_t, 8>;

  /// Informs the bus of the beginning and end of a transfer.
  class Transfer {
   public:
    explicit Transfer(const SdoClient& client) : client_(client) {
      client_.bus_.transfer(client_.node_, true);
    }
    ~Transfer() { client_.bus_.transfer(client_.node_, false); }
    Transfer(const Transfer&) = delete;
    Transfer& operator=(const Transfer&) = delete;

   private:
    const SdoClient& client_;
  };

  void write(Key key, std::span<const std::uint8_t> value, int times);
  Data request(Key key, const Data& data, int times = 1);
  Data answer(Key key);
  bool next_answer(Data& data, std::int64_t until_us);
  void send(const Data& data);
  void send_segments(Key key, std::span<const std::uint8_t> value);
  void send_blocks(Key key, std::span<const std::uint8_t> value, unsigned block_size);
  Bytes receive_segments(Key key, const Data& first);
  void receive_blocks(Key key, Bytes& value, std::size_t longest);
  std::uint8_t receive_block(Key key, Bytes& value, bool& last, unsigned& heard);
  std::size_t expected_size(Key key, bool announced, std::size_t size);
  [[noreturn]] void abort(Key key, std::uint32_t code);
  [[noreturn]] void refused(Key key, std::uint32_t code);
  std::string cause_of(std::uint32_t code);
  bool two_answer();
  void drop_old();
  [[noreturn]] void silent(Key key, int times = 1) const;

  Bus& bus_;
  unsigned node_;
  std::int64_t timeout_us_ = usual_timeout_us;
};

}  // namespace smaservo::can
