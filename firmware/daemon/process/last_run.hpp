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
  crashed,  ///< by a signal of its own making, which it noted down
  killed,   ///< something else ended it: kill -9, a watchdog, no memory
  power,    ///< the machine was started anew meanwhile: power cut or reset
};

struct LastRun {
  Ending ending = Ending::none;
  bool heated = false;  ///< when it ended
  int signal = 0;       ///< of a crash
  std::string result;   ///< as the service manager called it; empty where it said nothing
  bool unclean() const { return ending != Ending::none && ending != Ending::clean; }
};

/// One sentence.
std::string describe(const LastRun& last);

/// The mark that a run leaves, in the folder of the store: FOLDER/run. FOLDER/history keeps the
/// sentences of all unclean ends.
class RunMark {
 public:
  enum class State : unsigned char { idle, heated, ended };
  using Block = std::array<char, 128>;

  /// Reads the last run's mark and makes that of this one. `boot` names the machine's start. Throws
  /// UserError where the folder can not be written, or another process has its mark in it.
  RunMark(const std::string& folder, const std::string& boot);

  const LastRun& last() const { return last_; }
  /// Durable when it returns. False: the disk fails.
  bool set(State state);
  /// The same of a run that goes on: heated at once, idle when it has not been for a second.
  bool follow(bool heated, std::int64_t now_ns);

  // For a signal handler: pwrite() the block at the beginning.
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

/// For `smaservod --off`, which runs after the service has ended: keeps what systemd says of it.
void keep_service_result(const std::string& folder, const std::string& result);

}  // namespace smaservo::daemon
