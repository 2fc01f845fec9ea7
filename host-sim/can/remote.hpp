#pragma once
// A servo at the other end of the bus: its objects by name, its states, its parameters as a set.

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

/// "operational", of the byte that a heartbeat brings.
std::string nmt_state_text(unsigned state);

/// The state of CiA 402 that a statusword says.
std::string drive_state_text(unsigned statusword);

using Change = std::pair<text::KnownObject, Bytes>;

/// Everything throws UserError; what the node refuses names object, value and what is allowed.
class Remote {
 public:
  explicit Remote(SdoClient client) : client_(client) {}

  SdoClient& client() { return client_; }
  Bus& bus() { return client_.bus(); }
  unsigned node() const { return client_.node(); }

  Bytes read(const text::KnownObject& object);
  void write(const text::KnownObject& object, const Bytes& value);
  /// Of the name that find_object() takes.
  Bytes read(const std::string& name) { return read(text::find_object(name)); }
  std::string text(const std::string& name);
  double number(const std::string& name);
  void set(const std::string& name, const std::string& value);

  /// All of them in force in one step of the loop, or none; live, or while not enabled. A single
  /// one is written as it is.
  void change(const std::vector<Change>& changes);

  void nmt(NmtCommand command);
  /// Through the states of CiA 402 until current may flow. Says why where it can not.
  void enable();
  void disable();
  /// Acknowledges faults. Throws where one stays.
  void reset_faults();
  /// Mode 1 of CiA 402, in force.
  void set_profile_position();
  /// In Profile position, which it sets. Waits until the target is reached, at most so long.
  void move(std::int32_t target_um, double patience_s);
  /// 1010h:1: parameters and communication.
  void store();

 private:
  void commit(const std::vector<Change>& changes);
  void revert();
  [[noreturn]] void explain_refusal(const SdoError& error);
  bool wait_for(const std::function<bool(unsigned)>& reached, double patience_s);
  void control(unsigned word) { set("6040", std::to_string(word)); }
  unsigned status() { return static_cast<unsigned>(number("6041")); }
  std::string reasons();

  SdoClient client_;
};

}  // namespace smaservo::can
