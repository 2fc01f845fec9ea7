#pragma once
// The loop: frame in, step, drive out; once per period, as long as there are frames.

#include <algorithm>
#include <sched.h>
#include <utility>

#include "firmware/cycle.hpp"
#include "firmware/daemon/loop/command_source.hpp"
#include "firmware/daemon/loop/links.hpp"
#include "firmware/daemon/loop/pace.hpp"
#include "hal/linux/system/clock.hpp"

namespace smaservo::daemon {

struct LoopTiming {
  std::int64_t period_ns;
  bool from_zero;                ///< the device's time begins with 0, else with the first frame's
  std::uint64_t max_cycles = 0;  ///< 0: no end
};

/// Whether the times of a board's frames are those of CLOCK_MONOTONIC: such a board has a member of
/// this name. On other boards time stands still while a cycle is late.
template <class B>
inline constexpr bool in_monotonic_time = requires { requires B::in_monotonic_time; };

/// Longest time for which the loop of a simulated wire may stand still. The wire's time stands
/// still with the loop, and the scheduler of a PC is no fault of the device. On a real board the
/// lease takes its place.
inline constexpr std::int64_t longest_simulated_stall_ns = 1'000'000'000;

template <hal::Board B, class Pacing>
class Loop {
 public:
  Loop(B& board, Pacing pacing, PreparedDevice& device, CommandSource& source, LoopLinks& links,
       LoopFigures& figures, const LoopTiming& timing)
      : board_(board),
        pacing_(std::move(pacing)),
        device_(device),
        source_(source),
        links_(links),
        figures_(figures),
        timing_(timing) {}

  /// Runs one cycle. Returns false, and has switched the current off, when there are no more frames
  /// or the loop is to stop. It neither allocates, locks nor logs; its system calls are the board's
  /// and the sleep.
  bool cycle();

 private:
  void count_frame(hal::ReadStatus status);
  void count_setpoints(std::uint32_t come);
  bool stood_still(std::int64_t gone_ns) const;
  double advance_time(std::int64_t gone_ns);
  void adopt_sets(Command<double>& command);
  void renew_lease(bool heated);
  void note_stop(const Output<double>& before, std::int64_t sampled_ns, std::int64_t driven_ns);
  void leave_record();

  B& board_;
  Pacing pacing_;
  PreparedDevice& device_;
  CommandSource& source_;
  LoopLinks& links_;
  LoopFigures& figures_;
  LoopTiming timing_;
  hal::Frame frame_{};
  CycleRecord now_{};
  bool began_ = false;
  bool sequenced_ = false;
  std::uint32_t sequence_ = 0;
  std::int64_t last_ns_ = 0;
  std::int64_t time_ns_ = 0;  ///< the device's: the sum of its steps
};

template <hal::Board B, class Pacing>
bool Loop<B, Pacing>::cycle() {
  const Woke woke = pacing_.wait();
  const std::int64_t woke_ns = hal::monotonic_ns();
  const hal::ReadStatus status = board_.read(frame_);
  const bool over = timing_.max_cycles != 0 && now_.number >= timing_.max_cycles;
  if (over || status == hal::ReadStatus::end || links_.stop.load(std::memory_order_relaxed)) {
    links_.lease_ends_ns.store(0, std::memory_order_relaxed);
    board_.safe_off();
    return false;
  }
  // Measured after the read: a device's driver that blocked counts as well.
  const std::int64_t gone_ns = pacing_.gone_ns();
  const bool stalled = stood_still(gone_ns);
  if (in_monotonic_time<B> && stalled) {
    board_.safe_off();  // before the device computes what the stall has done
  }
  const std::int64_t sampled_ns = in_monotonic_time<B> ? frame_.time_ns : hal::monotonic_ns();
  count_frame(status);
  const double dt_s = advance_time(gone_ns);
  Cycle& cycle = now_.cycle;
  Heard<double> heard = source_.listen(cycle.time_s);
  heard.late = heard.late || (in_monotonic_time<B> && (woke.missed > 0 || stalled));
  heard.external = heard.external | FaultSet::from_bits(links_.faults.load());
  heard.external.add(Fault::loop_stalled, stalled);
  count_setpoints(heard.setpoints);
  adopt_sets(heard.command);
  const Output<double> before = cycle.output;
  run_cycle(board_, frame_, status, heard, timing_.period_ns, cycle,
            [&](const Inputs<double>& in, const Command<double>& command) {
              const Output<double> out = device_.step(in, command, dt_s);
              renew_lease(is_heated(out.state));
              return out;
            });
  const std::int64_t driven_ns = hal::monotonic_ns();
  source_.tell(cycle, dt_s);
  links_.output.put(cycle.output);
  const WarningCount& told = cycle.output.told_count;
  figures_.warning_causes.at(told.place).store(told.causes, std::memory_order_relaxed);
  note_stop(before, sampled_ns, driven_ns);
  leave_record();
  // The first frame does not count: it lay there until the loop began.
  if (status == hal::ReadStatus::frame && now_.number > 1) {
    figures_.sample_to_drive.add(driven_ns - sampled_ns);
  }
  figures_.wake.add(woke.late_ns);
  figures_.missed.fetch_add(woke.missed, std::memory_order_relaxed);
  figures_.execution.add(hal::monotonic_ns() - woke_ns);
  figures_.cycles.fetch_add(1, std::memory_order_relaxed);
  return true;
}

template <hal::Board B, class Pacing>
void Loop<B, Pacing>::count_frame(hal::ReadStatus status) {
  if (status != hal::ReadStatus::frame) {
    figures_.no_frame.fetch_add(1, std::memory_order_relaxed);
    return;
  }
  const std::uint32_t passed = frame_.sequence - sequence_;
  if (sequenced_ && passed > 1) {
    figures_.lost_frames.fetch_add(passed - 1, std::memory_order_relaxed);
  }
  sequenced_ = true;
  sequence_ = frame_.sequence;
}

/// The master's clock and the loop's are not locked to each other: now and then two set-points come
/// before one cycle, and then none before the next.
template <hal::Board B, class Pacing>
void Loop<B, Pacing>::count_setpoints(std::uint32_t come) {
  figures_.setpoints.fetch_add(come, std::memory_order_relaxed);
  figures_.superseded.fetch_add(come > 1 ? come - 1 : 0, std::memory_order_relaxed);
}

/// Whether real time has gone on for longer than the lease since the last cycle.
template <hal::Board B, class Pacing>
bool Loop<B, Pacing>::stood_still(std::int64_t gone_ns) const {
  return in_monotonic_time<B> ? is_stall(gone_ns, timing_.period_ns)
                              : longest_simulated_stall_ns < gone_ns;
}

/// The device steps over all of a stall, in one step; see Device::step(). A converter's buffer may
/// give frames from before it, so the loop's own time counts then.
template <hal::Board B, class Pacing>
double Loop<B, Pacing>::advance_time(std::int64_t gone_ns) {
  const bool by_frame = !in_monotonic_time<B> || !stood_still(gone_ns);
  const std::int64_t longest_ns =
      in_monotonic_time<B> && by_frame ? leased_periods * timing_.period_ns : longest_stall_ns;
  const std::int64_t gone_by_ns = by_frame ? frame_.time_ns - last_ns_ : gone_ns;
  const std::int64_t step_ns =
      began_ ? std::clamp(gone_by_ns, shortest_step_ns, longest_ns) : timing_.period_ns;
  if (began_) {
    time_ns_ += step_ns;
  } else {
    time_ns_ = timing_.from_zero ? 0 : frame_.time_ns;
  }
  began_ = true;
  last_ns_ = by_frame ? frame_.time_ns : board_.now_ns();
  now_.cycle.time_s = static_cast<double>(time_ns_) / 1e9;
  return static_cast<double>(step_ns) * 1e-9;
}

/// Adopts at most one parameter set a cycle. A wire that this very cycle switches off counts as
/// off. A wire that is off is not armed while more sets wait, since a set that was accepted as one
/// for a wire without current has to be in force before the current flows. An arm command that
/// comes meanwhile takes effect later. One that was there before stays, since its return would look
/// like a new command.
template <hal::Board B, class Pacing>
void Loop<B, Pacing>::adopt_sets(Command<double>& command) {
  now_.set = 0;
  ParameterSet* set = nullptr;
  const bool is_off = !is_heated(now_.cycle.output.state);
  if (links_.new_sets.pop(set)) {
    const ParameterSet* const asked = set;
    set = device_.adopt(set, !is_off && command.arm);
    now_.set = set == asked ? 0 : number_of(*asked);
    // There is room: the ring holds more sets than can be under way.
    links_.old_sets.push(set);
  }
  const bool was_asked = now_.cycle.command.arm;
  if (is_off && !was_asked && !links_.new_sets.empty()) {
    command.arm = false;
  }
}

/// Called before the drive gets its command, so that the guard ends the heat if the loop hangs
/// there.
template <hal::Board B, class Pacing>
void Loop<B, Pacing>::renew_lease(bool heated) {
  const std::int64_t leased_ns =
      in_monotonic_time<B> ? leased_periods * timing_.period_ns : longest_simulated_stall_ns;
  const std::int64_t ends_ns = hal::monotonic_ns() + leased_ns;
  links_.lease_ends_ns.store(heated ? ends_ns : 0, std::memory_order_relaxed);
  links_.heated.store(heated, std::memory_order_relaxed);
}

template <hal::Board B, class Pacing>
void Loop<B, Pacing>::note_stop(const Output<double>& before, std::int64_t sampled_ns,
                                std::int64_t driven_ns) {
  const Output<double>& now = now_.cycle.output;
  if (!(before.drive_current_A > 0 && now.drive_current_A == 0)) {
    return;
  }
  for_each_fault(now.latched - before.latched, [&](Fault fault) {
    LoopFigures::Stop& stop = figures_.stops[static_cast<std::size_t>(fault)];
    stop.count.fetch_add(1, std::memory_order_relaxed);
    stop.longest_ns.store(std::max(stop.longest_ns.load(), driven_ns - sampled_ns),
                          std::memory_order_relaxed);
  });
}

template <hal::Board B, class Pacing>
void Loop<B, Pacing>::leave_record() {
  ++now_.number;
  if (links_.record == nullptr) {
    return;
  }
  bool kept = links_.record->push(now_);
  while (!Pacing::in_time && !kept && !links_.stop.load(std::memory_order_relaxed)) {
    sched_yield();
    kept = links_.record->push(now_);
  }
  if (!kept) {
    links_.unrecorded.fetch_add(1, std::memory_order_relaxed);
  }
}

}  // namespace smaservo::daemon
