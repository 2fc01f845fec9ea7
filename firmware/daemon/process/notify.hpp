#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "hal/linux/system/descriptor.hpp"

namespace smaservo::daemon {

/// Tells systemd the state of the service (sd_notify(3)) by datagrams to the socket that
/// NOTIFY_SOCKET names. Does nothing if the variable is not set. A message that cannot be sent at
/// once is lost.
class ServiceManager {
 public:
  /// Takes the socket and the watchdog's period from the environment.
  ServiceManager();
  /// Sends to this socket: a path, or "@name" for an abstract one; empty: sends nothing.
  explicit ServiceManager(std::string_view socket);

  void ready() { send("READY=1"); }
  void stopping() { send("STOPPING=1"); }
  void alive() { send("WATCHDOG=1"); }
  void status(std::string_view text) { send("STATUS=" + std::string(text)); }
  /// Period at which alive() is due: half of WATCHDOG_USEC; 0: there is no watchdog.
  std::int64_t alive_every_ns() const { return alive_every_ns_; }

 private:
  void send(const std::string& text);

  std::string socket_;
  hal::Descriptor datagrams_;
  std::int64_t alive_every_ns_ = 0;
};

}  // namespace smaservo::daemon
