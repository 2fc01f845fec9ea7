#pragma once
// Connects the bus, the CANopen node and the loop: frames go between bus and node, the node's
// commands to the loop, the loop's outputs to the node. A node is canopen::Servo or a class with
// the same members.

#include <atomic>
#include <cstdint>
#include <utility>

#include "firmware/command.hpp"
#include "firmware/daemon/loop/command_source.hpp"
#include "firmware/daemon/loop/ring.hpp"
#include "hal/board.hpp"
#include "hal/linux/can/can_status.hpp"

namespace smaservo::daemon {

/// The report of a cycle of the loop to the node.
struct CycleReport {
  Output<double> output;
  Inputs<double> inputs;
  double dt_s;
};

/// A message of the node to the loop.
struct NodeSays {
  Command<double> command;
  FaultSet external;
  std::uint32_t setpoints = 0;  ///< set-points received in cyclic modes since the start
};

/// The bus as a command source of the loop. A command is fresh in one cycle only. After `lease_s`
/// without a sign of life from the bus's thread the command source counts as lost, so that heat
/// does not outlive the thread that requests it.
class BusCommandSource : public CommandSource {
 public:
  explicit BusCommandSource(double lease_s) : lease_s_(lease_s) {}

  Heard<double> listen(double time_s) override;
  void tell(const Cycle& cycle, double dt_s) override {
    reports_.push({cycle.output, cycle.inputs, dt_s});
  }

  // Called by the bus's thread.
  void say(const NodeSays& says) { says_.put(says); }
  bool next(CycleReport& report) { return reports_.pop(report); }

 private:
  double lease_s_;
  Latest<NodeSays> says_;
  /// While the ring is full, the node misses reports, which does no harm.
  Ring<CycleReport> reports_{256};
  NodeSays last_{};
  double said_s_ = 0;
  std::uint32_t setpoints_ = 0;
  bool said_ = false;
};

inline Heard<double> BusCommandSource::listen(double time_s) {
  const bool fresh = says_.take(last_);
  if (fresh || !said_) {
    said_ = said_ || fresh;
    said_s_ = time_s;
  }
  last_.command.fresh = fresh && last_.command.fresh;
  const bool lost = said_ && time_s - said_s_ > lease_s_;
  FaultSet external = last_.external;
  external.add(Fault::bus_lost, lost);
  const std::uint32_t come = last_.setpoints - std::exchange(setpoints_, last_.setpoints);
  return {last_.command, external, false, come};
}

/// round() does one round of the bus's thread: it gives the node the received frames, the reports
/// of the loop's cycles and the time, and sends the node's frames. `give_settings()` gives the loop
/// the settings that the node has put in force meanwhile, if there are any.
template <hal::CanPort Port, class Node>
class BusPump {
 public:
  BusPump(Port& port, Node& node, BusCommandSource& source)
      : port_(port), node_(node), source_(source) {}

  template <class Give>
  void round(std::uint64_t now_us, FaultSet port_faults, Give give_settings) {
    hal::CanFrame frame;
    for (int i = 0; i < max_frames && port_.receive(frame); ++i) {
      node_.receive(frame, now_us);
      ++frames_;
    }
    CycleReport report{};
    while (source_.next(report)) {
      node_.publish(report.output, report.inputs, report.dt_s);
    }
    node_.advance(now_us);
    const NodeSays says{node_.command(), node_.external() | port_faults, node_.setpoints()};
    // A command that ends the heat goes before new settings, which may need a wire without current;
    // a command to heat goes after them.
    if (!says.command.arm) {
      source_.say(says);
    }
    give_settings();
    source_.say(says);
    send(now_us);
  }

  std::uint64_t frames() const { return frames_; }
  /// Whether the next round must follow at once, because the node may have more to send.
  bool has_more() const { return has_more_; }
  /// Frames that were not sent.
  std::uint64_t dropped() const { return dropped_; }
  /// Number of times that the queue was full.
  std::uint64_t queue_full() const { return queue_full_; }

 private:
  // Greatest number of frames sent in one round. Sending more of an SDO block would keep the thread
  // from receiving for so long that a SYNC is handled only after the next one has come.
  static constexpr int max_sent = 4;
  // Time after which a frame is dropped: long enough for ten frames even on a slow bus.
  static constexpr std::uint64_t patience_us = 20'000;

  /// The kernel's queue holds ten frames, an SDO block has 127. A frame that the queue does not
  /// accept is tried again in the next rounds; the node makes its next frame only when this one has
  /// been sent or dropped. No call blocks.
  void send(std::uint64_t now_us) {
    has_more_ = false;
    int tries = 0;
    for (; tries < max_sent && (waits_ || node_.take(next_)); ++tries) {
      since_us_ = waits_ ? since_us_ : now_us;
      const bool sent = port_.send(next_);
      const hal::CanState state = port_.state();
      const bool reachable = state != hal::CanState::down && state != hal::CanState::gone;
      waits_ = !sent && reachable && now_us - since_us_ < patience_us;
      if (!sent && !waits_) {
        ++dropped_;
      }
      if (!sent && reachable) {
        ++queue_full_;
        return;
      }
    }
    has_more_ = tries == max_sent;
  }

  // Greatest number of frames received in one round: a flood on the bus must not stop the node's
  // time.
  static constexpr int max_frames = 256;

  Port& port_;
  Node& node_;
  BusCommandSource& source_;
  hal::CanFrame next_{};
  bool waits_ = false;  ///< next_ waits for room in the queue
  bool has_more_ = false;
  std::uint64_t since_us_ = 0;
  std::uint64_t frames_ = 0, dropped_ = 0, queue_full_ = 0;
};

}  // namespace smaservo::daemon
