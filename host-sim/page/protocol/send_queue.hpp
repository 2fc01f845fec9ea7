#pragma once
// What waits for one client. Live messages are for whoever keeps up: the oldest are dropped and
// counted. Answers are for whoever has asked: none is dropped, and they go first.

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
  /// Live messages of a second at 1 kHz: 256 were too few where other programs kept both sides from
  /// running for longer than that. The longest answers are exported recordings.
  struct Bounds {
    std::size_t live_messages = 1024, live_bytes = std::size_t{1} << 20U;
    std::size_t answers = 1024, answer_bytes = std::size_t{32} << 20U;
  };

  SendQueue() = default;
  explicit SendQueue(const Bounds& bounds) : bounds_(bounds) {}

  /// False: the client has left so many answers unread that it should be closed.
  bool push(Frame frame);
  /// The next one, answers first.
  std::optional<Frame> pop();

  bool empty() const { return live_.empty() && answers_.empty(); }
  std::size_t size() const { return live_.size() + answers_.size(); }
  std::uint64_t dropped() const { return dropped_; }
  /// Counts live messages that were lost before they came here.
  void count_dropped(std::uint64_t messages) { dropped_ += messages; }

 private:
  Bounds bounds_;
  std::deque<Frame> live_, answers_;
  std::size_t live_bytes_ = 0, answer_bytes_ = 0;
  std::uint64_t dropped_ = 0;
};

}  // namespace smaservo::page
