#pragma once
// One servo as the bridge knows it: its last readings, its live samples, its state as a message.

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

/// Objects that are read repeatedly for the state, always in a transfer of a single frame.
struct StateObject {
  Key key;
  bool always;  ///< read even without clients, to see whether the servo is present, and whether it
                ///< may heat
};
const std::vector<StateObject>& state_objects();

/// How the bridge shows the servo that the commander is still present.
struct Commanded {
  bool by_pdo = false;  ///< RPDO1 carries controlword and mode
  std::optional<std::uint16_t> word;
  std::optional<std::int8_t> mode;
  std::int64_t time_us = 0;
};

/// The last readings of a servo's parameters. All functions may be called from any thread.
class KnownParameters {
 public:
  /// Stores the value; returns whether it differs from the one before.
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
  std::int64_t left_us = -1'000'000'000;  ///< time at which the servo was first missed
  bool joined = false;  ///< its parameters have been read since it appeared or restarted
  bool duplicate = false;
  std::optional<unsigned> heartbeat_state;
  std::map<Key, std::uint32_t> values;  ///< values of state_objects()
  std::optional<Sample> freeze_frame;   ///< newest sample at the time when the first cause was seen
  bool unsaved = false;
  double rate_hz = 0;
  std::uint64_t gaps = 0;

  Commanded commanded;
  /// Usual value of 2002h:1, while the bridge has shortened it.
  std::optional<float> usual_timeout_s;
  /// Time from which on a statusword shows whether the axis is still enabled.
  std::int64_t enabled_us = 0;

  std::shared_ptr<History> history = std::make_shared<History>();
  std::shared_ptr<KnownParameters> parameters = std::make_shared<KnownParameters>();
  std::optional<std::uint32_t> changes_seen;  ///< last value of 2220h:1

  unsigned value(Key key) const;
  std::int32_t signed_value(Key key) const;
  unsigned statusword() const { return value({canopen::index::statusword, 0}); }
  bool is_enabled() const { return (statusword() & 0x6FU) == 0x27; }
  /// Whether current may flow: the axis is enabled, or an option code lets heat continue in another
  /// state.
  bool may_be_heated() const;
  int mode() const { return static_cast<std::int8_t>(value({canopen::index::mode_display, 0})); }
  /// The servo's name for people, such as "node 3 (smaservo)".
  std::string title() const;
};

/// Whether the key is the count of a warning that does not stand.
bool is_idle_count(const Servo& servo, Key key);

/// The message smaservo.State of PROTOCOL.md.
nlohmann::json state_message(const Servo& servo);

/// The modes of operation of firmware/canopen, with the unit of their targets.
struct ModeRow {
  int mode;
  const char* name;
  const char* unit;
};
const std::vector<ModeRow>& mode_rows();

}  // namespace smaservo::page
