#pragma once
// Everything around the loop: its thread, the guard, the recorder, the status, the mark of the run,
// signals. The same for every board.

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "firmware/daemon/loop/desk.hpp"
#include "firmware/daemon/process/last_run.hpp"
#include "firmware/daemon/process/realtime.hpp"
#include "firmware/daemon/status.hpp"
#include "hal/linux/system/off_action.hpp"

namespace smaservo {

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
  /// What keeps the board from settings that SIGHUP has read; empty: nothing. None: no board does.
  std::function<std::string(const Settings<double>&)> problem = nullptr;
};

/// No exit code: the device is to be made anew from what is stored, as after switching on.
inline constexpr int start_anew = -1;

/// What a board and its loop give to the service. All of it is called by the loop's thread, but
/// safe_off() once more after its end.
struct Served {
  std::function<bool()> turn;
  std::function<void()> safe_off;
  std::vector<OffAction> off;
};

class Recorder;

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

  /// Until turn() says no, or a signal comes. The exit code: 1 where the board or the recording
  /// failed; start_anew where the links asked for it.
  int run(const Served& served);

 private:
  void loop(const Served& served);
  void guard(const std::vector<OffAction>& off);
  void record();
  void watch();
  void count();
  void mark_heat(std::int64_t now_ns);
  void log_faults();
  void reload();
  void warn(const std::string& text);
  Status status();
  void write_status();
  void end_mark();
  void say_end();

  ServiceSetup setup_;
  LoopLinks links_;
  std::unique_ptr<LoopFigures> figures_;
  ParameterDesk desk_;
  PreparedDevice device_;
  std::unique_ptr<RunMark> mark_;
  std::unique_ptr<Ring<TurnRecord>> ring_;
  std::unique_ptr<Recorder> recorder_;
  Output<double> output_{};
  FaultSet logged_;
  std::vector<std::string> warnings_;
  std::vector<std::string> thread_warnings_;  ///< the loop's, before thread_ is set
  std::string error_;                         ///< that ended the loop
  std::unique_ptr<WatchedThread> watched_;
  std::atomic<WatchedThread*> thread_{nullptr};
  PageFaults first_faults_;
  std::uint64_t first_instructions_ = 0, first_turn_ = 0;
  bool counting_ = false;
  std::mutex count_mutex_;
  std::optional<PageFaults> last_faults_;
  std::optional<std::uint64_t> last_instructions_;
  std::atomic<std::uint64_t> guard_stops_{0};
  std::atomic<bool> loop_over_{false};
  bool marked_heated_ = false, status_fails_ = false, asked_to_end_ = false;
  std::int64_t cold_since_ns_ = 0;
};

}  // namespace smaservo
