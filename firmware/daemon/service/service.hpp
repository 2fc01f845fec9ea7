#pragma once
// Everything around the loop: the threads of loop, guard and recorder, and the main one, which has
// signals, status and the mark of the run. The same for every board.

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "firmware/daemon/process/last_run.hpp"
#include "firmware/daemon/service/reloader.hpp"
#include "firmware/daemon/status/status_writer.hpp"
#include "hal/linux/system/off_action.hpp"

namespace smaservo::daemon {

struct ServiceSetup {
  std::string board;  ///< as the status calls it
  Settings<double> settings;
  std::string settings_file;  ///< read anew at SIGHUP; empty: none
  std::string folder;         ///< of the store and the mark; empty: nothing is kept
  std::string record;         ///< file or folder; empty: nothing is recorded
  std::string status;         ///< file; empty: none
  bool json = false;          ///< at the end
  bool real_time = true;      ///< locks memory, asks for a priority
  bool paced = true;          ///< in time: the guard watches the lease
  bool sandboxed = false;     ///< the loop dies of any system call but a loop's
  RealTimeSettings thread;
  Reloader::Problem problem = nullptr;
};

/// No exit code: the device is to be made anew from what is stored, as after switching on.
inline constexpr int start_anew = -1;

/// What a board and its loop give to the service. All of it is called by the loop's thread, but
/// safe_off() once more after its end.
struct Served {
  std::function<bool()> cycle;
  std::function<void()> safe_off;
  std::vector<hal::OffAction> off;
};

class Recorder;
class ServiceManager;

class Service {
 public:
  /// SIGTERM, SIGINT and SIGHUP are its own from now on. Throws UserError.
  explicit Service(ServiceSetup setup);
  ~Service();
  Service(const Service&) = delete;
  Service& operator=(const Service&) = delete;

  LoopLinks& links() { return links_; }
  LoopFigures& figures() { return *figures_; }
  ParameterDesk& desk() { return desk_; }
  PreparedDevice& device() { return device_; }

  /// Until cycle() says no, or a signal comes. The exit code: 1 where the board or the recording
  /// failed; start_anew where the links asked for it.
  int run(const Served& served);

 private:
  void loop(const Served& served);
  void record();
  void watch(ServiceManager& manager);
  void answer(int signal, const Reloader& reloader, ServiceManager& manager);
  void look();
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
  // The loop's thread's.
  std::vector<std::string> thread_warnings_;  ///< before usage_ has begun
  std::string error_;                         ///< that ended the loop
  std::atomic<bool> loop_over_{false};
  // The main thread's.
  StatusWriter status_;
  bool asked_to_end_ = false;
};

}  // namespace smaservo::daemon
