#pragma once
// One bus for the transfers of clients and for the traffic that continues meanwhile: live values,
// SYNC, renewals. Each received frame passes here first, so that the traffic loses none during a
// long transfer of an SdoClient.

#include <array>
#include <atomic>
#include <exception>

#include "host-sim/can/bus/bus.hpp"
#include "host-sim/page/servos/control.hpp"

namespace smaservo::page {

/// Thrown by functions that use the bus when they must end at once.
class Interrupted : public std::exception {
 public:
  const char* what() const noexcept override { return "ended, since the servo is switched off"; }
};

/// The traffic beside the requests of clients.
class Traffic {
 public:
  virtual ~Traffic() = default;
  virtual void heard(const hal::CanFrame& frame, std::int64_t now_us) = 0;
  /// Sends the frames that are due. Returns the time at which it must be called again.
  virtual std::int64_t tick(std::int64_t now_us) = 0;
  /// Called after a client has sent a frame.
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

  /// The nodes with which a client's transfer is in progress.
  const NodeSet& busy() const { return busy_; }
  /// Ends the operation that uses the bus. May be called from any thread.
  void interrupt() { interrupted_ = true; }
  /// Withdraws an interrupt whose operation has ended already.
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
