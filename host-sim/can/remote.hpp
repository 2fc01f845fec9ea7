#pragma once
// A servo on the bus: access to its objects by name, its states, and its parameters as a set.

#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "firmware/text/canopen/objects.hpp"
#include "host-sim/can/sdo_client.hpp"

namespace smaservo::can {

/// Commands of the network management (CiA 301, 7.2.8.2.1).
enum class NmtCommand : std::uint8_t {
  start = 0x01,
  stop = 0x02,
  pre_operational = 0x80,
  reset_node = 0x81,
  reset_communication = 0x82,
};

/// The name of the state that the byte of a heartbeat encodes, such as "operational".
std::string nmt_state_text(unsigned state);

/// The name of the CiA 402 state that a statusword encodes.
std::string drive_state_text(unsigned statusword);

using Change = std::pair<text::KnownObject, Bytes>;

/// All functions throw UserError. If the node refuses a value, the message names the object, the
/// value and the allowed values.
class Remote {
 public:
  explicit Remote(SdoClient client) : client_(client) {}

  SdoClient& client() { return client_; }
  Bus& bus() { return client_.bus(); }
  unsigned node() const { return client_.node(); }

  /// Whether a write without an answer is repeated: only what may be executed twice.
  enum class Write : std::uint8_t { once, again };

  Bytes read(const text::KnownObject& object);
  void write(const text::KnownObject& object, const Bytes& value, Write how = Write::once);
  /// `name` as for find_object().
  Bytes read(const std::string& name) { return read(text::find_object(name)); }
  std::string text(const std::string& name);
  double number(const std::string& name);
  /// The value of an object that is a counter, a state or a set of bits. Throws UserError if the
  /// node answers with no such value, as a node of another make may.
  std::uint32_t whole(const std::string& name);
  void set(const std::string& name, const std::string& value, Write how = Write::once);

  /// Writes changes of parameters as one set: all take effect in the same step of the loop, or none
  /// does. A single change, or a change of another object, is written directly.
  void change(const std::vector<Change>& changes);

  /// Puts changes of parameters in force as one set for this time; then the node takes them back
  /// unless they are kept, and earlier if a client that stays has been silent for
  /// tuning.client_timeout_s. If it throws, nothing has changed.
  enum class Client : std::uint8_t { stays, leaves };
  void try_for(const std::vector<Change>& changes, double seconds, Client client = Client::stays);
  void keep_trial();
  void revert_trial();

  void nmt(NmtCommand command);
  /// Goes through the states of CiA 402 until current may flow. The error gives the reason if that
  /// is not possible.
  void enable();
  void disable();
  /// Acknowledges faults. Throws if a fault remains.
  void reset_faults();
  /// Sets a mode of CiA 402 and waits until it is in force.
  void set_mode(int mode);
  /// Sets mode 1 of CiA 402 and waits until it is in force.
  void set_profile_position() { set_mode(1); }
  /// Gives an enabled axis a new target in mode Profile position, and waits until it is accepted.
  void start_move(std::int32_t target_um);
  /// Sets mode Profile position and the target, and waits up to `patience_s` until it is reached.
  void move(std::int32_t target_um, double patience_s);
  /// Keeps an enabled axis enabled for this time, by repeating the last command. Throws if the axis
  /// is no longer enabled, or if somebody else commands it.
  void hold(double for_s);
  /// Shows the node that the commander is still present, by writing the controlword again. To be
  /// called often while heat is wanted; it writes only every renewal_us.
  void renew();
  /// Stores parameters and communication settings (1010h:1).
  void store();

 private:
  void stage(const std::vector<Change>& changes, const char* command);
  void revert();
  [[noreturn]] void explain_refusal(const SdoError& error);
  bool wait_for(const std::function<bool(unsigned)>& reached, double patience_s);
  void control(unsigned word) { set("6040", std::to_string(word)); }
  unsigned status() { return whole("6041"); }
  std::string reasons();

  static constexpr std::int64_t renewal_us = 500'000;

  SdoClient client_;
  std::int64_t renewed_us_ = 0;
};

}  // namespace smaservo::can
