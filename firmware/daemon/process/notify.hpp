#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "hal/linux/system/descriptor.hpp"

namespace smaservo::daemon {

/// Tells systemd how the service is (sd_notify(3)): datagrams to the socket that NOTIFY_SOCKET
/// names. Does nothing where there is none. What can not be sent is lost, never waited for.
class ServiceManager {
 public:
  /// As the environment says.
  ServiceManager();
  /// To this socket: a path, or "@name" of an abstract one; empty: none.
  explicit ServiceManager(std::string_view socket);

  void ready() { send("READY=1"); }
  void stopping() { send("STOPPING=1"); }
  void alive() { send("WATCHDOG=1"); }
  void status(std::string_view text) { send("STATUS=" + std::string(text)); }
  /// Half of WATCHDOG_USEC, as alive() is due; 0: no watchdog waits for it.
  std::int64_t alive_every_ns() const { return alive_every_ns_; }

 private:
  void send(const std::string& text);

  std::string socket_;
  hal::Descriptor datagrams_;
  std::int64_t alive_every_ns_ = 0;
};

}  // namespace smaservo::daemon
