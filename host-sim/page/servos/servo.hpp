#pragma once
// One servo as the bridge sees it: what was read last, its live samples, its state as a message.

#include <map>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "firmware/canopen/node/index.hpp"
#include "firmware/parameters/parameters.hpp"
#include "host-sim/can/sdo_client.hpp"
#include "host-sim/page/servos/history.hpp"

namespace smaservo::page {

/// Objects that are read again and again for the state, and never in a transfer of more than one
/// frame.
struct StateObject {
  Key key;
  bool always;  ///< also when nobody looks: whether the servo is there, and whether it may heat
};
const std::vector<StateObject>& state_objects();

/// How the servo is told that whoever commands is still there.
struct Commanded {
  bool by_pdo = false;  ///< RPDO1 carries controlword and mode
  std::optional<std::uint16_t> word;
  std::optional<std::int8_t> mode;
  std::int64_t time_us = 0;
};

/// The values of a servo's parameters as they were read last. All functions from any thread.
class KnownParameters {
 public:
  /// Whether the value is another one than before.
  bool put(std::size_t row, Value value);
  std::optional<Value> get(std::size_t row) const;

 private:
  mutable std::mutex mutex_;
  std::array<std::optional<Value>, parameter_count> values_;
};

struct Servo {
  explicit Servo(unsigned number) : node(number) {}

  unsigned node;
  std::string name;
  bool online = false;
  std::int64_t left_us = -1'000'000'000;  ///< when it was missed
  bool joined = false;  ///< its parameters have been read since it came or restarted
  bool duplicate = false;
  std::optional<unsigned> heartbeat_state;
  std::map<Key, std::uint32_t> values;  ///< of state_objects()
  std::optional<Sample> freeze_frame;   ///< the newest sample when the first cause was seen
  bool unsaved = false;
  double rate_hz = 0;
  std::uint64_t gaps = 0;

  Commanded commanded;
  std::optional<float> usual_timeout_s;  ///< of 2002h:1, while the bridge has made it shorter
  std::int64_t enabled_us = 0;           ///< since then a statusword says whether it still is

  std::shared_ptr<History> history = std::make_shared<History>();
  std::shared_ptr<KnownParameters> parameters = std::make_shared<KnownParameters>();
  std::optional<std::uint32_t> changes_seen;  ///< of 2220h:1

  unsigned value(Key key) const;
  std::int32_t signed_value(Key key) const;
  unsigned statusword() const { return value({canopen::index::statusword, 0}); }
  bool is_enabled() const { return (statusword() & 0x6FU) == 0x27; }
  /// Current may flow: enabled, or an option code lets heat go on in another state.
  bool may_be_heated() const;
  int mode() const { return static_cast<std::int8_t>(value({canopen::index::mode_display, 0})); }
  /// "node 3 (smaservo)"
  std::string title() const;
};

/// smaservo.State of PROTOCOL.md.
nlohmann::json state_message(const Servo& servo);

/// Modes of operation that firmware/canopen has, with the unit of their targets.
struct ModeRow {
  int mode;
  const char* name;
  const char* unit;
};
const std::vector<ModeRow>& mode_rows();

}  // namespace smaservo::page
