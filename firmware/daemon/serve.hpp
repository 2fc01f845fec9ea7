#pragma once
// Makes a board and its service from a command line.

#include "firmware/daemon/bus/kept_settings.hpp"
#include "firmware/daemon/loop/loop.hpp"
#include "firmware/daemon/options.hpp"
#include "firmware/daemon/process/off_actions.hpp"
#include "firmware/daemon/service/service.hpp"

namespace smaservo::daemon {

/// SCHED_FIFO priority of the bus's thread: above threads without real-time priority, below the
/// loop's and, by default, below the kernel's interrupt threads (50).
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

/// Logs in one line what runs, unless the options say --quiet: board, bus (empty: none), node-id,
/// wire, period, and that the current is off, until what. To be called before the loop begins.
void say_start(const DaemonOptions& options, const std::string& board, const std::string& bus,
               const KeptSettings& kept);

LoopTiming timing_of(const Settings<double>& settings, double for_s);
ServiceSetup service_setup(const DaemonOptions& options, const Settings<double>& settings);

/// All return the exit code: 0, 1, or EX_CONFIG if a file is refused. They throw UserError,
/// TraceError, DeviceError or CanError; a ConfigError also means EX_CONFIG.
int serve_simulation(const DaemonOptions& options);
int serve_replay(const DaemonOptions& options);
int serve_board(const DaemonOptions& options);
int check_board(const DaemonOptions& options);
/// Checks for a simulated wire or a recording: read the files and open the bus, but run nothing.
int check_simulation(const DaemonOptions& options);
int check_replay(const DaemonOptions& options);
int switch_board_off(const DaemonOptions& options);
/// Returns 0 if the board drives the device `options.owns`, otherwise 1.
int tell_owned(const DaemonOptions& options);

}  // namespace smaservo::daemon
