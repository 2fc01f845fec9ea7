#include "firmware/daemon/service/service.hpp"

#include <cmath>
#include <csignal>
#include <cstdio>
#include <exception>
#include <fmt/format.h>
#include <thread>

#include "firmware/daemon/process/crash.hpp"
#include "firmware/daemon/process/notify.hpp"
#include "firmware/daemon/process/sandbox.hpp"
#include "firmware/daemon/process/signals.hpp"
#include "firmware/daemon/service/guard.hpp"
#include "firmware/daemon/status/recorder.hpp"
#include "firmware/text/device_names.hpp"
#include "hal/linux/system/clock.hpp"
#include "model/files/message.hpp"

namespace smaservo::daemon {
namespace {

constexpr std::int64_t ms = 1'000'000;
constexpr std::int64_t status_every_ns = 1000 * ms;
constexpr std::int64_t look_every_ns = 20 * ms;
constexpr double recorded_s = 16;  ///< time for which the recorder's ring has room

std::string sentence(const DeviceState state, FaultSet latched) {
  return latched.empty() ? std::string(text::state_name(state))
                         : fmt::format("{}: {}", text::state_name(state), text::names_of(latched));
}

}  // namespace

Service::Service(ServiceSetup setup)
    : setup_(std::move(setup)),
      figures_(std::make_unique<LoopFigures>()),
      desk_(setup_.settings, links_),
      device_(desk_.first()),
      status_(setup_.status, setup_.board, std::llround(setup_.settings.timing.period_s * 1e9),
              {links_, *figures_, usage_, mark_, recorder_}) {
  take_signals();
  if (!setup_.folder.empty()) {
    mark_ = std::make_unique<RunMark>(setup_.folder, boot_id());
    if (mark_->last().unclean()) {
      status_.warn(describe(mark_->last()));
      FaultSet faults = FaultSet::from_bits(links_.faults.load());
      faults.set(Fault::unclean_boot, mark_->last().heated);
      links_.faults.store(faults.bits());
    }
  }
  if (!setup_.record.empty()) {
    const double cycles = recorded_s / setup_.settings.timing.period_s;
    ring_ = std::make_unique<Ring<CycleRecord>>(static_cast<std::size_t>(cycles));
    recorder_ =
        std::make_unique<Recorder>(setup_.record, setup_.settings, *ring_, desk_, setup_.board);
    links_.record = ring_.get();
  }
  if (setup_.real_time) {
    const std::string refused = lock_memory();
    if (!refused.empty()) {
      status_.warn(refused);
    }
  }
}

Service::~Service() = default;

int Service::run(const Served& served) {
  ServiceManager manager;
  {
    const CrashGuard crash(served.off, mark_.get(), links_.heated);
    const std::jthread loop_thread([&] { loop(served); });
    std::optional<LeaseGuard> guard;
    std::jthread record_thread;
    try {
      if (setup_.paced) {
        guard.emplace(served.off, setup_.real_time ? std::optional(setup_.thread) : std::nullopt,
                      links_.lease_ends_ns, figures_->guard_stops);
      }
      record_thread = std::jthread([&] {
        name_thread("recorder");
        record();
      });
      manager.ready();
      watch(manager);
    } catch (...) {
      // The threads are about to be joined, and the loop's thread ends only when it is told to.
      links_.stop.store(true);
      throw;
    }
  }
  served.safe_off();
  error_ = error_.empty() ? ended_by_ : error_;
  const bool anew = links_.restart.load() && !asked_to_end_ && error_.empty();
  if (anew) {
    end_mark();
    return start_anew;
  }
  say_end();
  return error_.empty() && (!recorder_ || recorder_->problem().empty()) ? 0 : 1;
}

void Service::loop(const Served& served) {
  loop_signal_stack_.use();
  name_thread("loop");
  if (setup_.real_time) {
    thread_warnings_ = make_real_time(setup_.thread);
  }
  usage_.begin();
  if (setup_.sandboxed) {
    error_ = allow_loop_calls_only();
  }
  try {
    while (error_.empty() && served.cycle()) {
    }
  } catch (const std::exception& error) {
    error_ = error.what();
    served.safe_off();
  }
  if (!setup_.sandboxed) {
    usage_.end();
  }
  loop_over_.store(true);
}

void Service::record() {
  if (!recorder_) {
    return;
  }
  while (!loop_over_.load()) {
    recorder_->pump();
    std::this_thread::sleep_for(std::chrono::milliseconds(setup_.paced ? 20 : 1));
  }
  recorder_->finish();
}

void Service::watch(ServiceManager& manager) {
  const Reloader reloader({setup_.settings_file, setup_.folder, setup_.problem}, desk_,
                          links_.heated);
  std::int64_t alive_ns = 0;
  std::int64_t status_ns = 0;
  std::uint64_t cycles = 0;
  while (!loop_over_.load()) {
    answer(wait_for_signal(look_every_ns), reloader, manager);
    const std::int64_t now_ns = hal::monotonic_ns();
    look();
    if (mark_ && !mark_->follow(links_.heated.load(), now_ns)) {
      status_.warn(fmt::format("{}/run: cannot be written", setup_.folder));
    }
    if (now_ns - status_ns >= status_every_ns) {
      status_ns = now_ns;
      status_.write(true);
      manager.status(sentence(status_.output().state, status_.output().latched));
    }
    // The watchdog is triggered only while the loop makes cycles, not just because this thread
    // runs.
    const std::uint64_t cycles_now = figures_->cycles.load();
    if (cycles_now != cycles && manager.alive_every_ns() > 0 &&
        now_ns - alive_ns >= manager.alive_every_ns() / 2) {
      alive_ns = now_ns;
      cycles = cycles_now;
      manager.alive();
    }
  }
}

void Service::answer(int signal, const Reloader& reloader, ServiceManager& manager) {
  if (signal == SIGHUP) {
    reloader.reload();
  } else if (signal != 0) {
    if (signal == SIGXCPU) {
      ended_by_ = "the limit of processor time is reached (SIGXCPU)";
    }
    manager.stopping();
    asked_to_end_ = true;
    links_.stop.store(true);
  }
}

void Service::look() {
  if (!desk_.reloads().bus_serves()) {
    desk_.tidy();
  }
  for (const std::string& sentence : desk_.reloads().take_said()) {
    status_.warn(sentence);
  }
  for (const std::string& changes : desk_.take_refused()) {
    status_.warn("taken back, as the wire was heated when it should come into force: " + changes);
  }
  status_.look();
  say_guard_stops();
  if (usage_.has_begun()) {
    for (const std::string& warning : std::exchange(thread_warnings_, {})) {
      status_.warn(warning);
    }
  }
}

/// Logs new stops by the guard at once, but at most once a second.
void Service::say_guard_stops() {
  const std::uint64_t stops = figures_->guard_stops.load();
  const std::int64_t now_ns = hal::monotonic_ns();
  if (stops == said_stops_ || (said_stops_ != 0 && now_ns - said_stops_ns_ < status_every_ns)) {
    return;
  }
  said_stops_ = stops;
  said_stops_ns_ = now_ns;
  files::complain("smaservod",
                  fmt::format("the guard switched the outputs off, because the loop hung; {} times "
                              "so far",
                              stops));
}

void Service::end_mark() {
  look();
  status_.write(false);
  if (mark_) {
    mark_->set(RunMark::State::ended);
  }
}

void Service::say_end() {
  end_mark();
  const Status now = status_.status(false);
  files::print(setup_.json ? status_json(now) : status_text(now));
  if (!error_.empty()) {
    files::complain("smaservod", error_);
  }
}

}  // namespace smaservo::daemon
