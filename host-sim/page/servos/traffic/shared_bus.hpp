#pragma once
// One bus for what a client asks and for what goes on meanwhile: live values, SYNC, renewals. A
// long transfer of an SdoClient loses nothing of the latter, since each frame passes here first.

#include <array>
#include <atomic>
#include <exception>

#include "host-sim/can/bus/bus.hpp"
#include "host-sim/page/servos/control.hpp"

namespace smaservo::page {

/// Thrown out of whatever uses the bus when it must end at once.
class Interrupted : public std::exception {
 public:
  const char* what() const noexcept override { return "ended, since the servo is switched off"; }
};

/// What goes on beside the requests of clients.
class Traffic {
 public:
  virtual ~Traffic() = default;
  virtual void heard(const hal::CanFrame& frame, std::int64_t now_us) = 0;
  /// Sends what is due; returns when it wants to be called again.
  virtual std::int64_t tick(std::int64_t now_us) = 0;
  /// A client has sent a frame.
  virtual void said(const hal::CanFrame& frame, std::int64_t now_us) = 0;
  /// Whether a request that Traffic has sent to this node waits for its answer.
  virtual bool waits_for(unsigned node, std::int64_t now_us) = 0;
};

class SharedBus final : public can::Bus {
 public:
  SharedBus(can::Bus& bus, Traffic& traffic) : bus_(bus), traffic_(traffic) {}

  /// Both throw Interrupted once after interrupt().
  void send(const hal::CanFrame& frame) override;
  bool receive(hal::CanFrame& frame, std::int64_t until_us) override;
  std::int64_t now_us() const override { return bus_.now_us(); }
  std::string name() const override { return bus_.name(); }
  void transfer(unsigned node, bool goes_on) override;

  /// The nodes with which a client's transfer goes on.
  const NodeSet& busy() const { return busy_; }
  /// From any thread: whoever uses the bus ends.
  void interrupt() { interrupted_ = true; }
  /// What an interrupt was for has ended already.
  void forget_interrupt() { interrupted_ = false; }

 private:
  void throw_if_interrupted() {
    if (interrupted_.exchange(false)) {
      throw Interrupted();
    }
  }

  can::Bus& bus_;
  Traffic& traffic_;
  NodeSet busy_;
  std::atomic<bool> interrupted_ = false;
};

}  // namespace smaservo::page
