#include "firmware/daemon/process/notify.hpp"

#include <algorithm>
#include <charconv>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <sys/socket.h>
#include <sys/un.h>

namespace smaservo::daemon {
namespace {

std::string_view environment(const char* name) {
  const char* const value = std::getenv(name);
  return value == nullptr ? "" : value;
}

std::int64_t number(std::string_view text) {
  std::int64_t value = 0;
  std::from_chars(text.data(), text.data() + text.size(), value);
  return value;
}

}  // namespace

ServiceManager::ServiceManager() : ServiceManager(environment("NOTIFY_SOCKET")) {
  const std::int64_t process = number(environment("WATCHDOG_PID"));
  if (process == 0 || process == getpid()) {
    alive_every_ns_ = std::max<std::int64_t>(number(environment("WATCHDOG_USEC")), 0) * 500;
  }
}

ServiceManager::ServiceManager(std::string_view socket)
    : socket_(socket),
      datagrams_(socket.empty() ? -1 : ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {}

void ServiceManager::send(const std::string& text) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (datagrams_.number() < 0 || socket_.size() >= sizeof(address.sun_path)) {
    return;
  }
  std::memcpy(address.sun_path, socket_.data(), socket_.size());
  if (socket_.front() == '@') {
    address.sun_path[0] = '\0';  // begins the name of an abstract socket
  }
  const std::size_t size = offsetof(sockaddr_un, sun_path) + socket_.size();
  sendto(datagrams_.number(), text.data(), text.size(), MSG_DONTWAIT | MSG_NOSIGNAL,
         reinterpret_cast<const sockaddr*>(&address),  // NOLINT(*-reinterpret-cast): sockets API
         static_cast<socklen_t>(size));
}

}  // namespace smaservo::daemon
