#include "hal/linux/can/can_multicast.hpp"

#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <net/if.h>
#include <netdb.h>
#include <sys/socket.h>

#include "hal/board.hpp"
#include "hal/linux/can/can_datagram.hpp"
#include "hal/linux/can/socket_option.hpp"

namespace smaservo::hal {

static_assert(CanPort<CanMulticast>);

namespace {

/// python-can's value; a frame needs about 170 bytes.
constexpr std::size_t longest_datagram = 4096;

/// Greatest number of datagrams that one call skips.
constexpr int max_datagrams = 64;

template <class Address>
Address as(const sockaddr_storage& general) {
  Address address;
  static_assert(sizeof address <= sizeof general);
  std::memcpy(&address, &general, sizeof address);
  return address;
}

// The functions of the sockets API take addresses of all families as this type.
// NOLINTBEGIN(cppcoreguidelines-pro-type-reinterpret-cast)
sockaddr* general(sockaddr_storage& address) {
  return reinterpret_cast<sockaddr*>(&address);
}
const sockaddr* general(const sockaddr_storage& address) {
  return reinterpret_cast<const sockaddr*>(&address);
}
// NOLINTEND(cppcoreguidelines-pro-type-reinterpret-cast)

bool same(const sockaddr_storage& one, const sockaddr_storage& other) {
  if (one.ss_family != other.ss_family) {
    return false;
  }
  if (one.ss_family == AF_INET) {
    const auto a = as<sockaddr_in>(one);
    const auto b = as<sockaddr_in>(other);
    return a.sin_port == b.sin_port && a.sin_addr.s_addr == b.sin_addr.s_addr;
  }
  const auto a = as<sockaddr_in6>(one);
  const auto b = as<sockaddr_in6>(other);
  return a.sin6_port == b.sin6_port &&
         std::memcmp(&a.sin6_addr, &b.sin6_addr, sizeof a.sin6_addr) == 0;
}

bool is_multicast(const sockaddr_storage& address) {
  if (address.ss_family == AF_INET) {
    return IN_MULTICAST(ntohl(as<sockaddr_in>(address).sin_addr.s_addr));
  }
  return as<sockaddr_in6>(address).sin6_addr.s6_addr[0] == 0xFF;
}

Descriptor udp_socket(int family) {
  return Descriptor(socket(family, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
}

int join(int socket, const MulticastAddress& group) {
  group_req request{};
  request.gr_interface = group.interface;
  request.gr_group = group.address;
  const int level = group.address.ss_family == AF_INET ? IPPROTO_IP : IPPROTO_IPV6;
  return set_option(socket, level, MCAST_JOIN_GROUP, request);
}

/// Receives the datagrams of the group, but no others that are sent to the same port.
int listen_to(int socket, const MulticastAddress& group) {
  const int error = set_option(socket, SOL_SOCKET, SO_REUSEADDR, 1);
  if (error != 0) {
    return error;
  }
  if (bind(socket, general(group.address), group.size) != 0) {
    return errno;
  }
  return join(socket, group);
}

int choose_interface(int socket, const MulticastAddress& group) {
  if (group.interface == 0) {
    return 0;
  }
  if (group.address.ss_family == AF_INET6) {
    return set_option(socket, IPPROTO_IPV6, IPV6_MULTICAST_IF, static_cast<int>(group.interface));
  }
  ip_mreqn request{};
  request.imr_ifindex = static_cast<int>(group.interface);
  return set_option(socket, IPPROTO_IP, IP_MULTICAST_IF, request);
}

double now_s() {
  return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
}

}  // namespace

MulticastAddress multicast_address(const std::string& group, std::uint16_t port) {
  const std::size_t percent = group.find('%');
  const std::string number = group.substr(0, percent);
  MulticastAddress result;
  if (percent != std::string::npos) {
    const std::string interface = group.substr(percent + 1);
    result.interface = if_nametoindex(interface.c_str());
    if (result.interface == 0) {
      throw CanError(group + ": no interface " + interface);
    }
  }
  addrinfo hints{};
  hints.ai_flags = AI_NUMERICHOST | AI_NUMERICSERV;
  hints.ai_socktype = SOCK_DGRAM;
  addrinfo* found = nullptr;
  if (getaddrinfo(number.c_str(), std::to_string(port).c_str(), &hints, &found) != 0) {
    throw CanNameError(group + ": is no multicast group of IPv4 or IPv6");
  }
  std::memcpy(&result.address, found->ai_addr, found->ai_addrlen);
  result.size = found->ai_addrlen;
  freeaddrinfo(found);
  if (!is_multicast(result.address)) {
    throw CanNameError(group + ": is no multicast group: 224.0.0.0 to 239.255.255.255 or ff00::/8");
  }
  if (result.address.ss_family == AF_INET6 && result.interface != 0) {
    auto scoped = as<sockaddr_in6>(result.address);
    scoped.sin6_scope_id = result.interface;
    std::memcpy(&result.address, &scoped, sizeof scoped);
  }
  return result;
}

CanMulticast::CanMulticast(const std::string& group, std::uint16_t port)
    : name_("udp:" + (group.find(':') == std::string::npos ? group : "[" + group + "]") + ":" +
            std::to_string(port)),
      group_(multicast_address(group, port)),
      receiver_(udp_socket(group_.address.ss_family)) {
  int error = receiver_.number() < 0 ? errno : listen_to(receiver_.number(), group_);
  if (error == 0) {
    connect_sender();
    if (sender_.number() < 0) {
      error = errno;
    }
  }
  if (error == ENODEV || error == ENETUNREACH) {
    throw CanError(name_ + ": this machine has no route to the group");
  }
  if (error != 0) {
    throw CanError(name_ + ": " + std::strerror(error));
  }
}

/// Opens the sender; if there is no route to the group, leaves it closed and sets errno.
void CanMulticast::connect_sender() {
  Descriptor sender = udp_socket(group_.address.ss_family);
  if (sender.number() >= 0 && choose_interface(sender.number(), group_) == 0 &&
      connect(sender.number(), general(group_.address), group_.size) == 0) {
    socklen_t size = sizeof own_address_;
    getsockname(sender.number(), general(own_address_), &size);
    sender_ = std::move(sender);
  }
}

bool CanMulticast::receive(CanFrame& frame) {
  for (int reads = 0; reads < max_datagrams; ++reads) {
    std::array<std::uint8_t, longest_datagram> datagram;
    sockaddr_storage from{};
    socklen_t from_size = sizeof from;
    const ssize_t size = recvfrom(receiver_.number(), datagram.data(), datagram.size(),
                                  MSG_DONTWAIT | MSG_TRUNC, general(from), &from_size);
    if (size < 0) {
      return false;
    }
    if (same(from, own_address_)) {
      continue;
    }
    const auto bytes = static_cast<std::size_t>(size);
    const auto read =
        bytes > datagram.size() ? std::nullopt : from_datagram(std::span(datagram).first(bytes));
    if (read) {
      frame = *read;
      ++statistics_.received;
      return true;
    }
    ++statistics_.malformed;
  }
  return false;
}

bool CanMulticast::send(const CanFrame& frame) {
  // The network may have been lost and have come back with another address.
  if (sender_.number() < 0) {
    connect_sender();
  }
  const auto datagram = to_datagram(frame, now_s());
  if (sender_.number() >= 0 && ::send(sender_.number(), datagram.data(), datagram.size(),
                                      MSG_DONTWAIT | MSG_NOSIGNAL) >= 0) {
    state_ = CanState::active;
    ++statistics_.sent;
    return true;
  }
  if (sender_.number() >= 0 && (errno == ENOBUFS || errno == EAGAIN || errno == ENOMEM)) {
    ++statistics_.dropped_full;
    return false;
  }
  if (state_ == CanState::active) {
    ++statistics_.downs;
  }
  ++statistics_.dropped_down;
  state_ = CanState::down;
  sender_ = Descriptor();
  return false;
}

}  // namespace smaservo::hal
