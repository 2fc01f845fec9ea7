#include "firmware/daemon/process/realtime.hpp"

#include <cerrno>
#include <cstring>
#include <fmt/format.h>
#include <fstream>
#include <linux/capability.h>
#include <linux/perf_event.h>
#include <malloc.h>
#include <pthread.h>
#include <sched.h>
#include <sstream>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

namespace smaservo::daemon {
namespace {

constexpr std::size_t stack_size = std::size_t{256} * 1024;

/// Maps the pages of the stack before the loop needs them.
[[gnu::noinline]] void touch_stack() {
  std::byte stack[stack_size];
  std::memset(stack, 1, sizeof(stack));
  asm volatile("" : : "r"(&stack) : "memory");
}

bool has_capability(unsigned number) {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with("CapEff:")) {
      return (std::stoull(line.substr(7), nullptr, 16) >> number & 1U) != 0;
    }
  }
  return false;
}

bool may_have_priority(int priority) {
  rlimit limit{};
  getrlimit(RLIMIT_RTPRIO, &limit);
  return has_capability(CAP_SYS_NICE) || static_cast<int>(limit.rlim_cur) >= priority;
}

std::string why_no_priority(int error, int priority) {
  if (error == EPERM && may_have_priority(priority)) {
    return fmt::format(
        "no real-time priority although the rights are there: the kernel has "
        "CONFIG_RT_GROUP_SCHED and this control group has no real-time budget; give it one in "
        "cpu.rt_runtime_us, or run the service in the root group");
  }
  return fmt::format(
      "no real-time priority: {}; needs CAP_SYS_NICE or LimitRTPRIO={}; the loop will be late now "
      "and then",
      std::strerror(error), priority);
}

}  // namespace

void name_thread(const char* name) {
  pthread_setname_np(pthread_self(), name);
}

std::string lock_memory() {
  mallopt(M_TRIM_THRESHOLD, -1);
  mallopt(M_MMAP_MAX, 0);
  return mlockall(MCL_CURRENT | MCL_FUTURE) == 0
             ? ""
             : fmt::format("memory is not locked: {}; needs CAP_IPC_LOCK or LimitMEMLOCK=infinity",
                           std::strerror(errno));
}

std::vector<std::string> make_real_time(const RealTimeSettings& settings) {
  // Done before the thread has its priority: it takes half a millisecond, during which no other
  // real-time thread should wait.
  touch_stack();
  std::vector<std::string> warnings;
  if (settings.processor >= 0) {
    cpu_set_t set;
    CPU_ZERO(&set);
    CPU_SET(static_cast<unsigned>(settings.processor), &set);
    if (sched_setaffinity(0, sizeof(set), &set) != 0) {
      warnings.push_back(fmt::format("the loop does not stay on processor {}: {}",
                                     settings.processor, std::strerror(errno)));
    }
  }
  const sched_param parameters{.sched_priority = settings.priority};
  if (sched_setscheduler(0, SCHED_FIFO | SCHED_RESET_ON_FORK, &parameters) != 0) {
    warnings.push_back(why_no_priority(errno, settings.priority));
  }
  return warnings;
}

WatchedThread::WatchedThread() : thread_(static_cast<int>(syscall(SYS_gettid))) {
  perf_event_attr event{};
  event.type = PERF_TYPE_HARDWARE;
  event.size = sizeof(event);
  event.config = PERF_COUNT_HW_INSTRUCTIONS;
  event.exclude_kernel = 1;
  event.exclude_hv = 1;
  counter_ = hal::Descriptor(
      static_cast<int>(syscall(SYS_perf_event_open, &event, 0, -1, -1, PERF_FLAG_FD_CLOEXEC)));
}

std::optional<PageFaults> WatchedThread::page_faults() const {
  std::ifstream file(fmt::format("/proc/self/task/{}/stat", thread_));
  std::string line;
  std::getline(file, line);
  // The fields are counted from the end of the name, which may contain any character: proc(5).
  std::istringstream fields(line.substr(std::min(line.rfind(')') + 1, line.size())));
  std::string skipped;
  for (int i = 3; i < 10; ++i) {
    fields >> skipped;
  }
  PageFaults faults;
  fields >> faults.minor >> skipped >> faults.major;
  return fields ? std::optional(faults) : std::nullopt;
}

std::optional<std::uint64_t> WatchedThread::instructions() const {
  std::uint64_t count = 0;
  return counter_.number() >= 0 && read(counter_.number(), &count, sizeof(count)) == sizeof(count)
             ? std::optional(count)
             : std::nullopt;
}

}  // namespace smaservo::daemon
