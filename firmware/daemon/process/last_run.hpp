#pragma once
// A record of a run, from which the next run can tell how it ended.

#include <array>
#include <cstdint>
#include <string>

#include "hal/linux/system/descriptor.hpp"

namespace smaservo::daemon {

enum class Ending : unsigned char {
  none,  ///< there was no earlier run
  clean,
  crashed,  ///< one of crash_signals ended it, as the mark says
  killed,   ///< something else ended it: kill -9, a watchdog, lack of memory
  power,    ///< the machine was restarted meanwhile: power cut or reset
};

struct LastRun {
  Ending ending = Ending::none;
  bool heated = false;  ///< the wire was heated at the end
  int signal = 0;       ///< the signal of a crash
  std::string result;   ///< result as systemd names it; empty: unknown
  bool unclean() const { return ending != Ending::none && ending != Ending::clean; }
};

/// One sentence on how the last run ended.
std::string describe(const LastRun& last);

/// The mark of a run, in the folder of the store: FOLDER/run. FOLDER/history keeps the sentences of
/// all unclean ends.
class RunMark {
 public:
  enum class State : unsigned char { idle, heated, ended };
  using Block = std::array<char, 128>;

  /// Reads the last run's mark and writes this run's. `boot` identifies the machine's boot. Throws
  /// UserError if the folder cannot be written, or another process has its mark there.
  RunMark(const std::string& folder, const std::string& boot);

  const LastRun& last() const { return last_; }
  /// Writes the state durably. False if the disk fails.
  bool set(State state);
  /// Calls set() during the run: with `heated` at once, with `idle` after a second without heat.
  bool follow(bool heated, std::int64_t now_ns);

  // For a signal handler, which writes the block to the file's beginning with pwrite().
  int descriptor() const { return file_.number(); }
  Block crash_block(int signal, bool heated) const;

 private:
  Block block(const std::string& state) const;

  std::string boot_;
  hal::Descriptor file_;
  LastRun last_;
  bool marked_heated_ = false;
  std::int64_t cold_since_ns_ = 0;
};

/// The content of /proc/sys/kernel/random/boot_id.
std::string boot_id();

/// Keeps systemd's result of the service in the folder; `smaservod --off` calls it after the
/// service has ended.
void keep_service_result(const std::string& folder, const std::string& result);

}  // namespace smaservo::daemon
