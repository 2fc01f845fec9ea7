#pragma once
// What was written over the bus, and what was refused, in the daemon's log. By a thread of its own:
// whoever reads the log may be slow.

#include <atomic>
#include <functional>
#include <string>
#include <thread>

#include "firmware/canopen/servo/change_log.hpp"
#include "firmware/daemon/loop/ring.hpp"

namespace smaservo::daemon {

class BusJournal {
 public:
  using Say = std::function<void(const std::string&)>;

  /// A flood on the bus must not fill a disk: so many sentences at once, ten times a second.
  static constexpr unsigned max_at_once = 20;

  /// By default to the standard error output.
  explicit BusJournal(Say say = to_errors);

  // For the bus's thread; neither waits.
  void add(const canopen::LoggedChange& change) { ring_.push(change); }
  /// Of all that there have been, also of those that the node did not keep until they were added.
  void set_count(std::uint32_t count) { count_.store(count, std::memory_order_release); }

 private:
  static void to_errors(const std::string& text);
  void run(const std::stop_token& stop);
  void write();

  Say say_;
  Ring<canopen::LoggedChange> ring_{256};
  std::atomic<std::uint32_t> count_{0};
  std::uint32_t seen_ = 0;
  std::jthread thread_;  // last: it ends before what it uses
};

}  // namespace smaservo::daemon
