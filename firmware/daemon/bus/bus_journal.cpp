#include "firmware/daemon/bus/bus_journal.hpp"

#include <chrono>
#include <fmt/format.h>

#include "firmware/text/canopen/change_text.hpp"
#include "model/files/message.hpp"

namespace smaservo::daemon {

BusJournal::BusJournal(Say say)
    : say_(std::move(say)), thread_([this](const std::stop_token& stop) { run(stop); }) {}

void BusJournal::to_errors(const std::string& text) {
  files::complain("smaservod: bus", text);
}

void BusJournal::run(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    write();
  }
  write();
}

void BusJournal::write() {
  const std::uint32_t count = count_.load(std::memory_order_acquire);
  unsigned said = 0;
  std::uint32_t left_out = 0;
  for (canopen::LoggedChange change{}; ring_.pop(change); ++seen_) {
    if (said < max_at_once) {
      say_(text::change_text(change));
      ++said;
    } else {
      ++left_out;
    }
  }
  // Changes that were added after the count was read make `seen_` greater than `count`; the next
  // count includes them.
  if (seen_ < count) {
    left_out += count - seen_;
    seen_ = count;
  }
  if (left_out != 0) {
    say_(fmt::format("{} more changes and refusals, which are not listed", left_out));
  }
}

}  // namespace smaservo::daemon
