#pragma once
// A CAN bus of UDP datagrams to a multicast group: no kernel support, no hardware, no arbitration.
// Works with python-can's udp_multicast interface both ways.

#include <cstdint>
#include <netinet/in.h>
#include <string>

#include "hal/can_frame.hpp"
#include "hal/linux/can/can_status.hpp"
#include "hal/linux/system/descriptor.hpp"

namespace smaservo::hal {

inline constexpr const char* default_multicast_group = "ff15:7079:7468:6f6e:6465:6d6f:6d63:6173";
inline constexpr std::uint16_t default_multicast_port = 43113;

/// A multicast group of IPv4 or IPv6 with a port, on one interface.
struct MulticastAddress {
  sockaddr_storage address{};
  socklen_t size = 0;
  unsigned interface = 0;  ///< number of the interface; 0: chosen by the route
};

/// `group` is a numeric address; "%INTERFACE" after it selects the interface. Throws CanError.
MulticastAddress multicast_address(const std::string& group, std::uint16_t port);

/// A CanPort. Its own frames do not come back. Datagrams do not leave the local network.
class CanMulticast {
 public:
  /// Throws CanError, for example if the machine has no route to the group.
  explicit CanMulticast(const std::string& group = default_multicast_group,
                        std::uint16_t port = default_multicast_port);

  /// Makes two system calls. Datagrams that are not frames are counted and skipped.
  bool receive(CanFrame& frame);
  bool send(const CanFrame& frame);

  CanState state() const { return state_; }
  const CanStatistics& statistics() const { return statistics_; }
  const std::string& name() const { return name_; }
  /// The descriptor for poll(): readable when a datagram has been received.
  int descriptor() const { return receiver_.number(); }

 private:
  void connect_sender();

  std::string name_;
  MulticastAddress group_;
  Descriptor receiver_;
  Descriptor sender_;               ///< its port identifies the port's own datagrams
  sockaddr_storage own_address_{};  ///< local address of the sender
  CanState state_ = CanState::active;
  CanStatistics statistics_;
};

}  // namespace smaservo::hal
