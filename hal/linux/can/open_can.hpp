#pragma once
// Opens CAN ports by their names.

#include <span>
#include <string>
#include <variant>

#include "hal/linux/can/can_multicast.hpp"
#include "hal/linux/can/can_socket.hpp"

namespace smaservo::hal {

/// A CanPort that is a CanSocket or a CanMulticast.
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
  /// Restricts receive() to frames with these identifiers. A CanMulticast cannot filter and returns
  /// all.
  void accept(std::span<const std::uint32_t> ids) {
    if (auto* socket = std::get_if<CanSocket>(&port_)) {
      socket->accept(ids);
    }
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

/// `text` is the name of a CAN interface of the kernel, such as "can0"; or "udp", "udp:GROUP",
/// "udp:GROUP:PORT" for a multicast group, as in python-can's udp_multicast. An IPv6 group must be
/// in brackets if a port follows; "%INTERFACE" after the group selects the interface. Throws
/// CanError.
LinuxCan open_can(const std::string& text);

}  // namespace smaservo::hal
