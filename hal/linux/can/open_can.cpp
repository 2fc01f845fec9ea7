#include "hal/linux/can/open_can.hpp"

#include <algorithm>
#include <charconv>

#include "hal/board.hpp"

namespace smaservo::hal {

static_assert(CanPort<LinuxCan>);

namespace {

struct GroupAndPort {
  std::string group;
  std::string port;  ///< empty: the default port
};

/// Splits the text after "udp:".
GroupAndPort split(const std::string& text) {
  if (text.starts_with('[')) {
    const std::size_t end = text.find(']');
    const std::string rest = end == std::string::npos ? "" : text.substr(end + 1);
    if (end == std::string::npos || (!rest.empty() && rest.front() != ':')) {
      throw CanNameError("udp:" + text + ": must be udp:[GROUP]:PORT");
    }
    return {text.substr(1, end - 1), rest.empty() ? "" : rest.substr(1)};
  }
  // With more than one colon it is an IPv6 address without a port.
  const std::size_t colon = text.find(':');
  if (colon != std::string::npos && std::ranges::count(text, ':') == 1) {
    return {text.substr(0, colon), text.substr(colon + 1)};
  }
  return {text, ""};
}

std::uint16_t port_number(const std::string& text) {
  unsigned number = 0;
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, number);
  if (error != std::errc{} || stop != end || number == 0 || number > 65535) {
    throw CanNameError("udp: port " + text + ": must be a number from 1 to 65535");
  }
  return static_cast<std::uint16_t>(number);
}

}  // namespace

LinuxCan open_can(const std::string& text) {
  if (text == "udp") {
    return LinuxCan(CanMulticast());
  }
  if (!text.starts_with("udp:")) {
    return LinuxCan(CanSocket(text));
  }
  const GroupAndPort parts = split(text.substr(4));
  const std::uint16_t port = parts.port.empty() ? default_multicast_port : port_number(parts.port);
  return LinuxCan(CanMulticast(parts.group, port));
}

}  // namespace smaservo::hal
