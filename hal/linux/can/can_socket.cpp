#include "hal/linux/can/can_socket.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstddef>
#include <cstring>
#include <linux/can.h>
#include <linux/can/error.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <utility>

#include "hal/board.hpp"
#include "hal/linux/can/socket_option.hpp"

namespace smaservo::hal {

static_assert(CanPort<CanSocket>);

namespace {

/// Asks the kernel for the interface's number, flags or the like. False if there is no such
/// interface.
bool ask(int socket, const std::string& interface, unsigned long question, ifreq& answer) {
  answer = {};
  std::ranges::copy(interface, std::begin(answer.ifr_name));
  return ioctl(socket, question, &answer) == 0;
}

bool is_up(int socket, const std::string& interface) {
  ifreq answer;
  return ask(socket, interface, SIOCGIFFLAGS, answer) && (answer.ifr_flags & IFF_UP) != 0;
}

/// Greatest number of error frames that one call skips.
constexpr int max_reads = 64;

/// Errors of the whole controller. Errors of single bits are excluded: they come by thousands.
constexpr can_err_mask_t watched_errors =
    CAN_ERR_TX_TIMEOUT | CAN_ERR_CRTL | CAN_ERR_BUSOFF | CAN_ERR_RESTARTED | CAN_ERR_ACK;

/// The kernel's can_frame without its unions.
struct RawFrame {
  canid_t can_id;
  std::uint8_t length;
  std::array<std::uint8_t, 3> reserved;
  std::array<std::uint8_t, CAN_MAX_DLEN> data;
};
static_assert(sizeof(RawFrame) == CAN_MTU && offsetof(RawFrame, data) == offsetof(can_frame, data));

RawFrame to_kernel(const CanFrame& frame) {
  RawFrame raw{};
  raw.can_id = frame.extended ? (frame.id & CAN_EFF_MASK) | CAN_EFF_FLAG : frame.id & CAN_SFF_MASK;
  if (frame.remote) {
    raw.can_id |= CAN_RTR_FLAG;
  }
  raw.length = std::min<std::uint8_t>(frame.length, CAN_MAX_DLEN);
  std::ranges::copy(std::span(frame.data).first(raw.length), raw.data.begin());
  return raw;
}

CanFrame from_kernel(const RawFrame& raw) {
  CanFrame frame;
  frame.extended = (raw.can_id & CAN_EFF_FLAG) != 0;
  frame.remote = (raw.can_id & CAN_RTR_FLAG) != 0;
  frame.id = raw.can_id & (frame.extended ? CAN_EFF_MASK : CAN_SFF_MASK);
  frame.length = raw.length;
  if (!frame.remote) {
    std::ranges::copy(std::span(raw.data).first(raw.length), frame.data.begin());
  }
  return frame;
}

/// Reads one frame, and the kernel's count of frames that it had no room for. Returns -1 and sets
/// errno like read().
ssize_t read_frame(int socket, RawFrame& raw, std::uint32_t& overflow) {
  iovec place{&raw, sizeof raw};
  alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof overflow)> control{};
  msghdr message{};
  message.msg_iov = &place;
  message.msg_iovlen = 1;
  message.msg_control = control.data();
  message.msg_controllen = control.size();
  const ssize_t size = recvmsg(socket, &message, MSG_DONTWAIT);
  if (size < 0) {
    return size;
  }
  const cmsghdr* header = CMSG_FIRSTHDR(&message);
  if (header != nullptr && header->cmsg_level == SOL_SOCKET && header->cmsg_type == SO_RXQ_OVFL) {
    std::memcpy(&overflow, CMSG_DATA(header), sizeof overflow);
  }
  return size;
}

}  // namespace

CanSocket::CanSocket(std::string interface) : interface_(std::move(interface)) {
  if (interface_.empty() || interface_.size() >= IFNAMSIZ) {
    throw CanNameError("CAN interface \"" + interface_ + "\": a name has 1 to 15 characters");
  }
  socket_ = Descriptor(socket(PF_CAN, SOCK_RAW | SOCK_CLOEXEC | SOCK_NONBLOCK, CAN_RAW));
  if (socket_.number() < 0) {
    const bool unknown = errno == EAFNOSUPPORT || errno == EPROTONOSUPPORT;
    throw CanError(interface_ + ": " +
                   (unknown ? "this kernel has no CAN: load the modules can and can-raw"
                            : std::strerror(errno)));
  }
  int error = set_option(descriptor(), SOL_CAN_RAW, CAN_RAW_ERR_FILTER, watched_errors);
  if (error == 0) {
    error = set_option(descriptor(), SOL_SOCKET, SO_RXQ_OVFL, 1);
  }
  if (error == 0) {
    error = bind_interface();
  }
  if (error == ENODEV) {
    ifreq answer;
    const bool exists = ask(descriptor(), interface_, SIOCGIFINDEX, answer);
    throw CanError(interface_ + (exists ? ": is no CAN interface" : ": no such interface"));
  }
  if (error != 0) {
    throw CanError(interface_ + ": " + std::strerror(error));
  }
  if (!is_up(descriptor(), interface_)) {
    state_ = CanState::down;
  }
}

int CanSocket::bind_interface() {
  ifreq answer;
  if (!ask(descriptor(), interface_, SIOCGIFINDEX, answer)) {
    return errno;
  }
  sockaddr_can address{};
  address.can_family = AF_CAN;
  address.can_ifindex = answer.ifr_ifindex;
  // NOLINTNEXTLINE(cppcoreguidelines-pro-type-reinterpret-cast): bind() takes all families so
  const auto* general = reinterpret_cast<const sockaddr*>(&address);
  return bind(descriptor(), general, sizeof address) == 0 ? 0 : errno;
}

void CanSocket::accept(std::span<const std::uint32_t> ids) {
  accepted_.assign(ids.begin(), ids.end());
  accepts_all_ = false;
  const int error = set_filters();
  if (error != 0) {
    throw CanError(interface_ + ": filters: " + std::strerror(error));
  }
}

int CanSocket::set_filters() {
  std::vector<can_filter> filters;
  filters.reserve(accepted_.size() + 1);
  for (const std::uint32_t id : accepted_) {
    filters.push_back({id & CAN_SFF_MASK, CAN_SFF_MASK | CAN_EFF_FLAG | CAN_RTR_FLAG});
  }
  if (accepts_all_) {
    filters.push_back({0, 0});
  }
  const auto size = static_cast<socklen_t>(filters.size() * sizeof(can_filter));
  return setsockopt(descriptor(), SOL_CAN_RAW, CAN_RAW_FILTER, filters.data(), size) == 0 ? 0
                                                                                          : errno;
}

/// Clears the socket's pending error. Otherwise it would make the next call fail, and an interface
/// that has come back would count as gone again.
void CanSocket::forget_error() const {
  int error = 0;
  socklen_t size = sizeof error;
  getsockopt(descriptor(), SOL_SOCKET, SO_ERROR, &error, &size);
}

/// Called after a failure; returns whether frames can pass again.
bool CanSocket::bring_back() {
  if (state_ == CanState::gone) {
    if (bind_interface() != 0) {
      return false;
    }
    // The kernel has forgotten the filters together with the interface.
    if (set_filters() != 0) {
      return false;
    }
    ++statistics_.reopens;
    state_ = CanState::down;
    forget_error();
  }
  if (!is_up(descriptor(), interface_)) {
    return false;
  }
  forget_error();
  state_ = CanState::active;
  return true;
}

void CanSocket::failed(int error) {
  const bool was_there = state_ != CanState::down && state_ != CanState::gone;
  ifreq answer;
  // ENODEV or ENXIO although the interface exists: it has come back under another number.
  if (error == ENETDOWN) {
    state_ = CanState::down;
  } else if (error == ENODEV || error == ENXIO ||
             !ask(descriptor(), interface_, SIOCGIFINDEX, answer)) {
    state_ = CanState::gone;
  } else {
    return;
  }
  if (was_there) {
    ++statistics_.downs;
  }
}

bool CanSocket::receive(CanFrame& frame) {
  if (state_ == CanState::gone && !bring_back()) {
    return false;
  }
  for (int reads = 0; reads < max_reads; ++reads) {
    RawFrame raw;
    const std::uint32_t before = overflow_;
    const ssize_t size = read_frame(descriptor(), raw, overflow_);
    if (size < 0) {
      if (errno == EINTR) {
        continue;
      }
      if (errno != EAGAIN) {
        failed(errno);
      }
      if (errno == EAGAIN && state_ == CanState::down) {
        bring_back();
      }
      return false;
    }
    if (state_ == CanState::down) {
      bring_back();
    }
    statistics_.lost += overflow_ - before;
    if (size != CAN_MTU || raw.length > CAN_MAX_DLEN) {
      ++statistics_.malformed;
    } else if ((raw.can_id & CAN_ERR_FLAG) != 0) {
      note_error(raw.can_id, raw.data[1]);
    } else {
      frame = from_kernel(raw);
      ++statistics_.received;
      return true;
    }
  }
  return false;
}

void CanSocket::note_error(std::uint32_t classes, unsigned controller) {
  ++statistics_.error_frames;
  if ((classes & CAN_ERR_RESTARTED) != 0) {
    state_ = CanState::active;
  }
  if ((classes & CAN_ERR_CRTL) != 0 && state_ != CanState::bus_off) {
    constexpr unsigned passive = CAN_ERR_CRTL_RX_PASSIVE | CAN_ERR_CRTL_TX_PASSIVE;
    if ((controller & passive) != 0) {
      state_ = CanState::passive;
    }
    if ((controller & CAN_ERR_CRTL_ACTIVE) != 0) {
      state_ = CanState::active;
    }
  }
  if ((classes & CAN_ERR_BUSOFF) != 0) {
    if (state_ != CanState::bus_off) {
      ++statistics_.bus_offs;
    }
    state_ = CanState::bus_off;
  }
}

bool CanSocket::send(const CanFrame& frame) {
  if ((state_ == CanState::gone || state_ == CanState::down) && !bring_back()) {
    ++statistics_.dropped_down;
    return false;
  }
  const RawFrame raw = to_kernel(frame);
  if (::send(descriptor(), &raw, sizeof raw, MSG_DONTWAIT | MSG_NOSIGNAL) >= 0) {
    ++statistics_.sent;
    return true;
  }
  if (errno == ENOBUFS || errno == EAGAIN || errno == ENOMEM || errno == EINTR) {
    ++statistics_.dropped_full;
  } else {
    ++statistics_.dropped_down;
    failed(errno);
  }
  return false;
}

}  // namespace smaservo::hal
