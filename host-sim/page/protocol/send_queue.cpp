#include "host-sim/page/protocol/send_queue.hpp"

#include <utility>

namespace smaservo::page {

bool SendQueue::push(Frame frame) {
  const std::size_t size = frame.size();
  if (!frame.live) {
    answer_bytes_ += size;
    answers_.push_back(std::move(frame));
    return answers_.size() <= bounds_.answers && answer_bytes_ <= bounds_.answer_bytes;
  }
  live_bytes_ += size;
  live_.push_back(std::move(frame));
  // The newest message is kept, however long it is.
  while (live_.size() > 1 &&
         (live_.size() > bounds_.live_messages || live_bytes_ > bounds_.live_bytes)) {
    live_bytes_ -= live_.front().size();
    live_.pop_front();
    ++dropped_;
  }
  return true;
}

std::optional<Frame> SendQueue::pop() {
  std::deque<Frame>& from = answers_.empty() ? live_ : answers_;
  if (from.empty()) {
    return std::nullopt;
  }
  (answers_.empty() ? live_bytes_ : answer_bytes_) -= from.front().size();
  Frame next = std::move(from.front());
  from.pop_front();
  return next;
}

}  // namespace smaservo::page
