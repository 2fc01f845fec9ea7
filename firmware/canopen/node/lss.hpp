#pragma once
// LSS slave of CiA 305, with fastscan: a master sets node-id and bit rate without knowing the
// node-id.

#include <array>
#include <cstdint>
#include <span>

namespace smaservo::canopen {

inline constexpr std::uint16_t lss_request_id = 0x7E5;
inline constexpr std::uint16_t lss_answer_id = 0x7E4;
inline constexpr std::uint8_t unconfigured = 255;  ///< node-id of a node that has none
constexpr bool may_be_node_id(std::uint8_t id) {
  return (1 <= id && id <= 127) || id == unconfigured;
}

/// What the owner has to do after a request.
enum class LssAction : std::uint8_t {
  none,
  /// The pending node-id takes effect at the next reset of the communication; if the node has had
  /// none, at once when the configuration ends.
  node_id,
  store,     ///< store the pending node-id and bit rate; finish_store() answers
  activate,  ///< change to the pending bit rate after delay_ms, then silence for as long again
};

/// The bit rate of an entry of CiA 305's table; that of the first one if there is no such entry.
constexpr float bits_per_s(std::uint8_t entry) {
  constexpr std::array kbit_s{1000, 800, 500, 250, 125, 100, 50, 20, 10};
  return 1e3F * static_cast<float>(kbit_s[entry < kbit_s.size() ? entry : 0]);
}

class Lss {
 public:
  /// bit_rates: bit i allows CiA 305's table entry i (0: 1 Mbit/s .. 8: 10 kbit/s). Others are
  /// answered as not supported; if none is allowed there is nothing to activate.
  Lss(std::array<std::uint32_t, 4> identity, std::uint16_t bit_rates)
      : identity_(identity), bit_rates_(bit_rates) {}

  /// To be called after a reset, with the node-id and bit rate in force.
  void reset(std::uint8_t node_id, std::uint8_t bit_rate);
  LssAction receive(std::span<const std::uint8_t, 8> request);
  bool take(std::span<std::uint8_t, 8> answer);
  void finish_store(bool done);

  std::uint8_t pending_node_id() const { return pending_node_id_; }
  std::uint8_t pending_bit_rate() const { return pending_bit_rate_; }
  std::uint16_t delay_ms() const { return delay_ms_; }
  bool configures() const { return configures_; }

 private:
  using Request = std::span<const std::uint8_t, 8>;
  LssAction configure(Request request);
  LssAction switch_global(Request request);
  void select(Request request);
  void identify(Request request);
  void fastscan(Request request);
  void set_bit_rate(Request request);
  void inquire(std::uint8_t command);
  void answer(std::uint8_t command, std::uint32_t value = 0);

  std::array<std::uint32_t, 4> identity_;
  std::uint16_t bit_rates_;
  std::array<std::uint8_t, 8> answer_{};
  std::uint16_t delay_ms_ = 0;
  std::uint8_t node_id_ = unconfigured, pending_node_id_ = unconfigured;
  std::uint8_t pending_bit_rate_ = 0;
  std::uint8_t selected_ = 0;    ///< parts of the selective switch that have matched, as bits
  std::uint8_t identified_ = 0;  ///< parts of the identification that have matched, as bits
  std::uint8_t scanned_ = 0;     ///< index of the part that fastscan compares
  bool scanning_ = false;
  bool configures_ = false;
  bool answer_waits_ = false;
};

}  // namespace smaservo::canopen
