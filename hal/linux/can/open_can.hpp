#pragma once
// CAN ports by name.

#include <span>
#include <string>
#include <variant>

#include "hal/linux/can/can_multicast.hpp"
#include "hal/linux/can/can_socket.hpp"

namespace smaservo::hal {

/// A CanPort of either kind.
class LinuxCan {
 public:
  explicit LinuxCan(CanSocket port) : port_(std::move(port)) {}
  explicit LinuxCan(CanMulticast port) : port_(std::move(port)) {}

  bool receive(CanFrame& frame) {
    return std::visit([&](auto& port) { return port.receive(frame); }, port_);
  }
  bool send(const CanFrame& frame) {
    return std::visit([&](auto& port) { return port.send(frame); }, port_);
  }
  /// What else comes is not worth waking up for; a port that can not sort gives it all the same.
  void accept(std::span<const std::uint32_t> ids) {
    if (auto* socket = std::get_if<CanSocket>(&port_)) socket->accept(ids);
  }
  CanState state() const {
    return std::visit([](const auto& port) { return port.state(); }, port_);
  }
  const CanStatistics& statistics() const {
    return std::visit([](const auto& port) -> const auto& { return port.statistics(); }, port_);
  }
  const std::string& name() const {
    return std::visit([](const auto& port) -> const auto& { return port.name(); }, port_);
  }
  int descriptor() const {
    return std::visit([](const auto& port) { return port.descriptor(); }, port_);
  }

 private:
  std::variant<CanSocket, CanMulticast> port_;
};

/// "can0", any CAN interface of the kernel; or "udp", "udp:GROUP", "udp:GROUP:PORT", a multicast
/// group as python-can's udp_multicast has it. A group of IPv6 stands in brackets where a port
/// follows; "%INTERFACE" after the group keeps it there. Throws CanError.
LinuxCan open_can(const std::string& text);

}  // namespace smaservo::hal
