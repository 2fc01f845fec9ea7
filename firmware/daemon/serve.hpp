#pragma once
// From a command line to a board and its service.

#include "firmware/daemon/bus/kept_settings.hpp"
#include "firmware/daemon/loop/loop.hpp"
#include "firmware/daemon/options.hpp"
#include "firmware/daemon/process/off_actions.hpp"
#include "firmware/daemon/service/service.hpp"

namespace smaservo::daemon {

/// SCHED_FIFO priority of the bus's thread: above threads without one, below the loop's and, by
/// default, below the kernel's interrupt threads (50).
constexpr int bus_priority(const RealTimeSettings& loop) {
  return std::max(loop.priority / 2, 1);
}

/// Runs this board with this command source.
template <hal::Board B>
int serve(Service& service, B& board, CommandSource& source, const LoopTiming& timing, bool paced) {
  const auto run = [&](auto pacing) {
    Loop loop(board, pacing, service.device(), source, service.links(), service.figures(), timing);
    return service.run(
        {[&] { return loop.cycle(); }, [&] { board.safe_off(); }, off_actions_of(board)});
  };
  return paced ? run(Pace<hal::MonotonicClock>(timing.period_ns)) : run(NoPace{});
}

LoopTiming timing_of(const Settings<double>& settings, double for_s);
ServiceSetup service_setup(const DaemonOptions& options, const Settings<double>& settings);

/// All return the exit code: 0, 1, or EX_CONFIG where a file is refused. They throw UserError,
/// TraceError, DeviceError or CanError; a ConfigError means EX_CONFIG, too.
int serve_simulation(const DaemonOptions& options);
int serve_replay(const DaemonOptions& options);
int serve_board(const DaemonOptions& options);
int check_board(const DaemonOptions& options);
/// Of a simulated wire or a recording: reads the files and opens the bus; runs nothing.
int check_simulation(const DaemonOptions& options);
int check_replay(const DaemonOptions& options);
int switch_board_off(const DaemonOptions& options);
/// 0: the board drives the device `options.owns`; 1: it does not.
int tell_owned(const DaemonOptions& options);

}  // namespace smaservo::daemon
