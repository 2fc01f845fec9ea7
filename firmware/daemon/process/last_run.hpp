#pragma once
// What is kept of a run, so that the next one can say how it ended.

#include <array>
#include <cstdint>
#include <string>

#include "hal/linux/system/descriptor.hpp"

namespace smaservo::daemon {

enum class Ending : unsigned char {
  none,  ///< there was no run before
  clean,
  crashed,  ///< by one of crash_signals, noted in the mark
  killed,   ///< something else ended it: kill -9, a watchdog, no memory
  power,    ///< the machine was started anew meanwhile: power cut or reset
};

struct LastRun {
  Ending ending = Ending::none;
  bool heated = false;  ///< whether the wire was heated at the end
  int signal = 0;       ///< the signal of a crash
  std::string result;   ///< as systemd calls it; empty: unknown
  bool unclean() const { return ending != Ending::none && ending != Ending::clean; }
};

/// One sentence on how the last run ended.
std::string describe(const LastRun& last);

/// The mark that a run leaves, in the folder of the store: FOLDER/run. FOLDER/history keeps the
/// sentences of all unclean ends.
class RunMark {
 public:
  enum class State : unsigned char { idle, heated, ended };
  using Block = std::array<char, 128>;

  /// Reads the last run's mark and writes this one's. `boot` identifies the machine's start. Throws
  /// UserError where the folder cannot be written, or another process has its mark there.
  RunMark(const std::string& folder, const std::string& boot);

  const LastRun& last() const { return last_; }
  /// Writes the state, which is durable on return. False: the disk fails.
  bool set(State state);
  /// Calls set() while the run goes on: `heated` at once, `idle` after a second without heat.
  bool follow(bool heated, std::int64_t now_ns);

  // For a signal handler: it writes the block to the file's beginning with pwrite().
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

/// /proc/sys/kernel/random/boot_id
std::string boot_id();

/// Keeps systemd's result of the service in the folder; `smaservod --off` calls it after the
/// service's end.
void keep_service_result(const std::string& folder, const std::string& result);

}  // namespace smaservo::daemon
