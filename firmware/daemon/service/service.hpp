#pragma once
// Everything around the loop that is the same for every board: the threads of loop, guard and
// recorder, and the main thread, which handles signals, status and the run's mark.

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "firmware/daemon/process/crash.hpp"
#include "firmware/daemon/process/last_run.hpp"
#include "firmware/daemon/service/reloader.hpp"
#include "firmware/daemon/status/status_writer.hpp"
#include "hal/linux/system/off_action.hpp"

namespace smaservo::daemon {

struct ServiceSetup {
  std::string board;  ///< name of the board in the status
  Settings<double> settings;
  std::string settings_file;  ///< settings file that is read anew at SIGHUP; empty: none
  std::string folder;         ///< folder of the store and the mark; empty: nothing is kept
  std::string record;         ///< file or folder; empty: nothing is recorded
  std::string status;         ///< file; empty: none
  bool json = false;          ///< the status at the end is printed as JSON
  bool real_time = true;      ///< locks memory, sets priorities
  bool paced = true;          ///< runs in real time, so that the guard watches the lease
  bool sandboxed = false;     ///< restricts the loop's system calls, see sandbox.hpp
  RealTimeSettings thread;
  decltype(Reload::problem) problem = nullptr;
};

/// Result of Service::run() in place of an exit code: restart with the stored settings, as after
/// switching on.
inline constexpr int start_anew = -1;

/// The functions that a board and its loop give to the service. The loop's thread calls both; after
/// it has ended, the main thread calls safe_off() once more.
struct Served {
  std::function<bool()> cycle;
  std::function<void()> safe_off;
  std::vector<hal::OffAction> off;
};

class Recorder;
class ServiceManager;

class Service {
 public:
  /// Takes the signals from now on (signals.hpp). Throws UserError.
  explicit Service(ServiceSetup setup);
  ~Service();
  Service(const Service&) = delete;
  Service& operator=(const Service&) = delete;

  LoopLinks& links() { return links_; }
  LoopFigures& figures() { return *figures_; }
  ParameterDesk& desk() { return desk_; }
  PreparedDevice& device() { return device_; }

  /// Runs until cycle() returns false or a signal comes. Returns the exit code: 1 if the board or
  /// the recording failed; start_anew if LoopLinks::restart asks for it.
  int run(const Served& served);

 private:
  void loop(const Served& served);
  void record();
  void watch(ServiceManager& manager);
  void answer(int signal, const Reloader& reloader, ServiceManager& manager);
  void look();
  void say_guard_stops();
  void end_mark();
  void say_end();

  ServiceSetup setup_;
  LoopLinks links_;
  std::unique_ptr<LoopFigures> figures_;
  ParameterDesk desk_;
  PreparedDevice device_;
  std::unique_ptr<RunMark> mark_;
  std::unique_ptr<Ring<CycleRecord>> ring_;
  std::unique_ptr<Recorder> recorder_;
  LoopUsage usage_;
  SignalStack loop_signal_stack_;
  // Written by the loop's thread.
  std::vector<std::string> thread_warnings_;  ///< complete when usage_ has begun
  std::string error_;                         ///< reason why the loop ended by itself
  std::atomic<bool> loop_over_{false};
  // Used by the main thread only.
  StatusWriter status_;
  bool asked_to_end_ = false;
  std::string ended_by_;  ///< reason why the run was told to end, unless that is usual
  std::uint64_t said_stops_ = 0;
  std::int64_t said_stops_ns_ = 0;
};

}  // namespace smaservo::daemon
