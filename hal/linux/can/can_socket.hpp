#pragma once
// A CAN interface of Linux (SocketCAN).

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "hal/can_frame.hpp"
#include "hal/linux/can/can_status.hpp"
#include "hal/linux/system/descriptor.hpp"

namespace smaservo::hal {

/// A CanPort. The interface may go down, come up, disappear and come back: meanwhile frames are
/// dropped and counted. The port does not receive its own frames, but those of other programs on
/// the same machine.
class CanSocket {
 public:
  /// `interface`: the name that `ip link` shows; the interface may be down. Throws CanError.
  explicit CanSocket(std::string interface);

  /// Makes one or two system calls. Error frames are counted, not returned.
  bool receive(CanFrame& frame);
  /// Makes one system call; false if the queue is full or the interface down. Never tries again.
  bool send(const CanFrame& frame);

  /// From now on receive() returns only data frames with these 11-bit identifiers, of which at most
  /// 512 may be given; the kernel drops all others. Throws CanError.
  void accept(std::span<const std::uint32_t> ids);

  CanState state() const { return state_; }
  const CanStatistics& statistics() const { return statistics_; }
  const std::string& name() const { return interface_; }
  /// The descriptor for poll(): readable when a frame has been received. It never changes during
  /// the port's life.
  int descriptor() const { return socket_.number(); }

 private:
  int bind_interface();
  bool bring_back();
  void forget_error() const;
  void failed(int error);
  void note_error(std::uint32_t classes, unsigned controller);
  int set_filters();

  std::string interface_;
  Descriptor socket_;
  std::vector<std::uint32_t> accepted_;
  bool accepts_all_ = true;
  std::uint32_t overflow_ = 0;  ///< the kernel's count of lost frames
  CanState state_ = CanState::active;
  CanStatistics statistics_;
};

}  // namespace smaservo::hal
