#include "firmware/daemon/service.hpp"

#include <cmath>
#include <csignal>
#include <cstdio>
#include <exception>
#include <fmt/format.h>
#include <thread>

#include "firmware/daemon/process/crash.hpp"
#include "firmware/daemon/process/notify.hpp"
#include "firmware/daemon/process/sandbox.hpp"
#include "firmware/daemon/recorder.hpp"
#include "firmware/text/device_names.hpp"
#include "firmware/text/settings_file.hpp"
#include "hal/linux/system/clock.hpp"
#include "model/files/error.hpp"
#include "model/files/output_file.hpp"

namespace smaservo {
namespace {

constexpr std::int64_t ms = 1'000'000;
constexpr std::int64_t status_every_ns = 1000 * ms;
constexpr std::int64_t idle_after_ns = 1000 * ms;
constexpr std::int64_t look_every_ns = 20 * ms;
constexpr std::int64_t guard_every_ns = 2 * ms;
constexpr double recorded_s = 16;  ///< room of the ring

sigset_t own_signals() {
  sigset_t set;
  sigemptyset(&set);
  for (const int signal : {SIGTERM, SIGINT, SIGHUP}) {
    sigaddset(&set, signal);
  }
  return set;
}

/// The next of these signals; 0 after the time.
int wait_for_signal(std::int64_t time_ns) {
  const sigset_t set = own_signals();
  const timespec time{0, static_cast<long>(time_ns)};
  const int signal = sigtimedwait(&set, nullptr, &time);
  return signal > 0 ? signal : 0;
}

std::string sentence(const DeviceState state, FaultSet latched) {
  return latched.empty() ? std::string(state_name(state))
                         : fmt::format("{}: {}", state_name(state), names_of(latched));
}

}  // namespace

Service::Service(ServiceSetup setup)
    : setup_(std::move(setup)),
      figures_(std::make_unique<LoopFigures>()),
      desk_(setup_.settings, links_),
      device_(desk_.first()) {
  const sigset_t set = own_signals();
  pthread_sigmask(SIG_BLOCK, &set, nullptr);
  if (!setup_.folder.empty()) {
    mark_ = std::make_unique<RunMark>(setup_.folder, boot_id());
    if (mark_->last().unclean()) {
      warn(describe(mark_->last()));
      FaultSet faults = FaultSet::from_bits(links_.faults.load());
      faults.set(Fault::unclean_boot, mark_->last().heated);
      links_.faults.store(faults.bits());
    }
  }
  if (!setup_.record.empty()) {
    const double turns = recorded_s / setup_.settings.timing.period_s;
    ring_ = std::make_unique<Ring<TurnRecord>>(static_cast<std::size_t>(turns));
    recorder_ = std::make_unique<Recorder>(setup_.record, setup_.settings, *ring_, desk_);
    links_.record = ring_.get();
  }
  if (setup_.real_time) {
    const std::string refused = lock_memory();
    if (!refused.empty()) {
      warn(refused);
    }
  }
}

Service::~Service() = default;

int Service::run(const Served& served) {
  ServiceManager manager;
  {
    const CrashGuard crash(served.off, mark_.get(), links_.heated);
    const std::jthread loop_thread([&] { loop(served); });
    const std::jthread guard_thread([&] { guard(served.off); });
    const std::jthread record_thread([&] { record(); });
    manager.ready();
    std::int64_t alive_ns = 0;
    std::int64_t status_ns = 0;
    std::uint64_t turns = 0;
    while (!loop_over_.load()) {
      const int signal = wait_for_signal(look_every_ns);
      const std::int64_t now_ns = monotonic_ns();
      if (signal == SIGHUP) {
        reload();
      } else if (signal != 0) {
        manager.stopping();
        asked_to_end_ = true;
        links_.stop.store(true);
      }
      watch();
      mark_heat(now_ns);
      if (now_ns - status_ns >= status_every_ns) {
        status_ns = now_ns;
        write_status();
        manager.status(sentence(output_.state, output_.latched));
      }
      // A loop that hangs is not alive, whatever this thread does.
      const std::uint64_t turns_now = figures_->turns.load();
      if (turns_now != turns && manager.alive_every_ns() > 0 &&
          now_ns - alive_ns >= manager.alive_every_ns() / 2) {
        alive_ns = now_ns;
        turns = turns_now;
        manager.alive();
      }
    }
  }
  served.safe_off();
  const bool anew = links_.restart.load() && !asked_to_end_ && error_.empty();
  if (anew) {
    end_mark();
    return start_anew;
  }
  say_end();
  return error_.empty() && (!recorder_ || recorder_->problem().empty()) ? 0 : 1;
}

void Service::loop(const Served& served) {
  if (setup_.real_time) {
    thread_warnings_ = make_real_time(setup_.thread);
  }
  watched_ = std::make_unique<WatchedThread>();
  thread_.store(watched_.get(), std::memory_order_release);
  if (setup_.sandboxed) {
    error_ = allow_loop_calls_only();
  }
  try {
    while (error_.empty() && served.turn()) {
    }
  } catch (const std::exception& error) {
    error_ = error.what();
    served.safe_off();
  }
  if (!setup_.sandboxed) {
    count();
  }
  loop_over_.store(true);
}

/// The lease again, in software: where the loop hangs, in a device's driver as well, its outputs
/// still go off. What stops the whole program only the hardware's one-shot answers.
void Service::guard(const std::vector<OffAction>& off) {
  if (!setup_.paced) {
    return;
  }
  if (setup_.real_time) {
    RealTimeSettings above = setup_.thread;
    above.priority = std::min(above.priority + 1, 99);
    make_real_time(above);
  }
  std::int64_t revoked_ns = 0;
  std::int64_t next_ns = monotonic_ns();
  while (!loop_over_.load()) {
    next_ns = std::max(next_ns + guard_every_ns, monotonic_ns());
    MonotonicClock::sleep_until(next_ns);
    const std::int64_t ends_ns = links_.lease_ends_ns.load();
    if (ends_ns != 0 && ends_ns != revoked_ns && ends_ns < monotonic_ns()) {
      switch_off(off);
      revoked_ns = ends_ns;
      guard_stops_.fetch_add(1);
    }
  }
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

void Service::watch() {
  links_.output.take(output_);
  desk_.tidy();
  log_faults();
  const WatchedThread* const thread = thread_.load(std::memory_order_acquire);
  if (thread == nullptr) {
    return;
  }
  for (const std::string& warning : std::exchange(thread_warnings_, {})) {
    warn(warning);
  }
  // The first turns touch pages for the first time.
  if (!counting_ && figures_->turns.load() >= 100) {
    counting_ = true;
    first_turn_ = figures_->turns.load();
    first_faults_ = thread->page_faults().value_or(PageFaults{});
    first_instructions_ = thread->instructions().value_or(0);
  }
}

/// A thread that has ended can not be asked any more.
void Service::count() {
  const std::scoped_lock lock(count_mutex_);
  last_faults_ = watched_->page_faults();
  last_instructions_ = watched_->instructions();
}

void Service::mark_heat(std::int64_t now_ns) {
  if (!mark_) {
    return;
  }
  const bool heated = links_.heated.load();
  cold_since_ns_ = heated ? now_ns : cold_since_ns_;
  const bool wanted = heated || (marked_heated_ && now_ns - cold_since_ns_ < idle_after_ns);
  if (wanted != marked_heated_) {
    marked_heated_ = wanted;
    if (!mark_->set(wanted ? RunMark::State::heated : RunMark::State::idle)) {
      warn(fmt::format("{}/run: cannot be written", setup_.folder));
    }
  }
}

void Service::log_faults() {
  for_each_fault(output_.latched - logged_, [&](Fault fault) {
    fmt::print(stderr, "smaservod: {:.3f} s: {}: {}\n", static_cast<double>(output_.time_us) * 1e-6,
               fault_name(fault), fault_row(fault).text);
  });
  logged_ = output_.latched;
}

/// As a whole or not at all; what may change after a start only waits for it.
void Service::reload() {
  if (setup_.settings_file.empty()) {
    warn("SIGHUP: there is no settings file to read anew");
    return;
  }
  try {
    const Settings<double> from = load_settings_file(setup_.settings_file);
    const Settings<double> before = desk_.settings();
    Settings<double> to = before;
    for (const Parameter<double>& row : parameters<double>) {
      const bool may = row.change == Change::live ||
                       (row.change == Change::without_current && !links_.heated.load());
      if (may) {
        row.set(to, row.get(from));
      } else if (row.get(from) != row.get(before)) {
        warn(fmt::format("{}: {} is not changed: {}", setup_.settings_file, row.path.text(),
                         row.change == Change::after_reset ? "only with the next start"
                                                           : "not while the wire is heated"));
      }
    }
    if (!check(to).ok()) {
      warn(
          fmt::format("{}: nothing is changed: together with what stays the settings contradict "
                      "each other",
                      setup_.settings_file));
    } else if (const std::string problem = setup_.problem ? setup_.problem(to) : "";
               !problem.empty()) {
      warn(fmt::format("{}: nothing is changed: {}", setup_.settings_file, problem));
    } else if (!desk_.change(to)) {
      warn(fmt::format("{}: nothing is changed: too many changes at once", setup_.settings_file));
    }
  } catch (const std::exception& error) {
    warn(fmt::format("nothing is changed: {}", error.what()));
  }
}

void Service::warn(const std::string& text) {
  warnings_.push_back(text);
  fmt::print(stderr, "smaservod: {}\n", text);
}

Status Service::status() {
  Status now{.board = setup_.board,
             .period_ns = std::llround(setup_.settings.timing.period_s * 1e9),
             .figures = *figures_,
             .output = output_,
             .page_faults = {},
             .instructions = {},
             .guard_stops = guard_stops_.load(),
             .recording = {},
             .last_run = mark_ ? describe(mark_->last()) : "",
             .warnings = warnings_};
  if (counting_) {
    if (!loop_over_.load()) {
      count();
    }
    const std::scoped_lock lock(count_mutex_);
    if (last_faults_) {
      now.page_faults = {last_faults_->minor - first_faults_.minor,
                         last_faults_->major - first_faults_.major};
    }
    const std::uint64_t turns = figures_->turns.load() - first_turn_;
    if (last_instructions_ && turns > 0) {
      now.instructions = static_cast<double>(*last_instructions_ - first_instructions_) /
                         static_cast<double>(turns);
    }
  }
  if (recorder_) {
    now.recording = {recorder_->path(), recorder_->rows(), recorder_->problem()};
  }
  return now;
}

void Service::write_status() {
  if (setup_.status.empty() || status_fails_) {
    return;
  }
  try {
    OutputFile file(setup_.status);
    file.write(status_json(status()));
    file.commit();
  } catch (const UserError& error) {
    status_fails_ = true;
    warn(error.what());
  }
}

void Service::end_mark() {
  watch();
  write_status();
  if (mark_) {
    mark_->set(RunMark::State::ended);
  }
}

void Service::say_end() {
  end_mark();
  const Status now = status();
  std::fputs((setup_.json ? status_json(now) : status_text(now)).c_str(), stdout);
  if (!error_.empty()) {
    fmt::print(stderr, "smaservod: {}\n", error_);
  }
}

}  // namespace smaservo
