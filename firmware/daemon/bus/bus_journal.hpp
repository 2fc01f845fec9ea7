#pragma once
// Logs what was written over the bus, and what was refused. It has a thread of its own, because the
// reader of the log may be slow.

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

  /// Greatest number of sentences in a tenth of a second: a flood on the bus must not fill a disk.
  static constexpr unsigned max_at_once = 20;

  /// `say` gets each sentence; by default it prints to the standard error output.
  explicit BusJournal(Say say = to_errors);

  // Both are called by the bus's thread; neither blocks.
  void add(const canopen::LoggedChange& change) { ring_.push(change); }
  /// Number of all changes and refusals so far, including those that the node dropped before add().
  void set_count(std::uint32_t count) { count_.store(count, std::memory_order_release); }

 private:
  static void to_errors(const std::string& text);
  void run(const std::stop_token& stop);
  void write();

  Say say_;
  Ring<canopen::LoggedChange> ring_{256};
  std::atomic<std::uint32_t> count_{0};
  std::uint32_t seen_ = 0;
  std::jthread thread_;  // declared last, so that it ends before the members that it uses
};

}  // namespace smaservo::daemon
