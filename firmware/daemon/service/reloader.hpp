#pragma once
// Reads the settings file anew, which SIGHUP asks for. The order of precedence is that of a start,
// which README.md states: settings that are stored go before the file.

#include <string>
#include <vector>

#include "firmware/daemon/loop/desk.hpp"

namespace smaservo::daemon {

/// What becomes of settings by a file that was read anew.
struct Reloaded {
  bool taken = false;  ///< else nothing changes
  Settings<double> settings;
  std::vector<std::string> said;  ///< what has changed, what has not, and why
};

/// Changes the settings as a whole or not at all. Parameters that cannot change now, but only with
/// the next start or without heat, keep their values.
Reloaded reloaded(const Settings<double>& before, const Reload& reload, bool heated);

struct ReloadSetup {
  std::string file;    ///< empty: there is nothing to read
  std::string folder;  ///< of the store; empty: there is none
  decltype(Reload::problem) problem;
};

class Reloader {
 public:
  /// `desk` and `heated` must outlive the reloader.
  Reloader(ReloadSetup setup, ParameterDesk& desk, const std::atomic<bool>& heated)
      : setup_(std::move(setup)), desk_(desk), heated_(heated) {}

  /// The file goes to the thread that changes the settings, by the desk's ReloadBox, which has the
  /// answer later.
  void reload() const;

 private:
  void apply(const Reload& reload) const;

  ReloadSetup setup_;
  ParameterDesk& desk_;
  const std::atomic<bool>& heated_;
};

}  // namespace smaservo::daemon
