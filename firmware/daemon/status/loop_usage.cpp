#include "firmware/daemon/status/loop_usage.hpp"

namespace smaservo::daemon {

void LoopUsage::begin() {
  watched_ = std::make_unique<WatchedThread>();
  thread_.store(watched_.get(), std::memory_order_release);
}

void LoopUsage::look(std::uint64_t cycles) {
  // The first cycles are left out, because they touch pages for the first time.
  constexpr std::uint64_t first_cycles = 100;
  if (counts_ || !has_begun() || cycles < first_cycles) {
    return;
  }
  counts_ = true;
  first_cycle_ = cycles;
  const WatchedThread& thread = *thread_.load(std::memory_order_acquire);
  first_faults_ = thread.page_faults().value_or(PageFaults{});
  first_instructions_ = thread.instructions().value_or(0);
}

LoopUsage::Taken LoopUsage::taken(std::uint64_t cycles, bool runs) {
  if (!counts_) {
    return {};
  }
  if (runs) {
    ask();
  }
  const std::scoped_lock lock(mutex_);
  Taken taken;
  if (last_faults_) {
    taken.page_faults = {last_faults_->minor - first_faults_.minor,
                         last_faults_->major - first_faults_.major};
  }
  if (last_instructions_ && cycles > first_cycle_) {
    taken.instructions = static_cast<double>(*last_instructions_ - first_instructions_) /
                         static_cast<double>(cycles - first_cycle_);
  }
  return taken;
}

void LoopUsage::ask() {
  const std::scoped_lock lock(mutex_);
  last_faults_ = watched_->page_faults();
  last_instructions_ = watched_->instructions();
}

}  // namespace smaservo::daemon
