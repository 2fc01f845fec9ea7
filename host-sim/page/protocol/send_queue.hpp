#pragma once
// The frames that wait for one client. Live messages may be lost by a client that is too slow: the
// oldest are dropped and counted. Answers to a client's requests are never dropped, and are sent
// first.

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>

namespace smaservo::page {

/// A message of the socket. `body` is shared with the other clients that get it.
struct Frame {
  bool binary = false;
  bool live = false;
  std::string head;
  std::shared_ptr<const std::string> body;

  std::size_t size() const { return head.size() + (body ? body->size() : 0); }
};

class SendQueue {
 public:
  /// The bound of live messages holds one second at 1 kHz: 256 were too few when other programs
  /// kept both sides from running for longer than that. The longest answers are exported
  /// recordings.
  struct Bounds {
    std::size_t live_messages = 1024, live_bytes = std::size_t{1} << 20U;
    std::size_t answers = 1024, answer_bytes = std::size_t{32} << 20U;
  };

  SendQueue() = default;
  explicit SendQueue(const Bounds& bounds) : bounds_(bounds) {}

  /// False if the client has left so many answers unread that it should be closed.
  bool push(Frame frame);
  /// The next frame, answers first.
  std::optional<Frame> pop();

  bool empty() const { return live_.empty() && answers_.empty(); }
  std::size_t size() const { return live_.size() + answers_.size(); }
  std::uint64_t dropped() const { return dropped_; }
  /// Counts live messages that were lost before they reached the queue.
  void count_dropped(std::uint64_t messages) { dropped_ += messages; }

 private:
  Bounds bounds_;
  std::deque<Frame> live_, answers_;
  std::size_t live_bytes_ = 0, answer_bytes_ = 0;
  std::uint64_t dropped_ = 0;
};

}  // namespace smaservo::page
