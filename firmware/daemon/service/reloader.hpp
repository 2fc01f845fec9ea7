#pragma once
// Reads the settings file anew on SIGHUP. The order of precedence is the same as at a start, see
// README.md: stored settings have precedence over the file.

#include <string>
#include <vector>

#include "firmware/daemon/loop/desk.hpp"

namespace smaservo::daemon {

/// The result of reading a settings file anew.
struct Reloaded {
  bool taken = false;  ///< false: no settings change
  Settings<double> settings;
  std::vector<std::string> said;  ///< what has changed, what has not, and why
};

/// Changes the settings as a whole or not at all. Parameters that can change only at the next start
/// or without heat keep their values.
Reloaded reloaded(const Settings<double>& before, const Reload& reload, bool heated);

struct ReloadSetup {
  std::string file;    ///< empty: there is no file to read
  std::string folder;  ///< folder of the store; empty: there is none
  decltype(Reload::problem) problem;
};

class Reloader {
 public:
  /// `desk` and `heated` must outlive the reloader.
  Reloader(ReloadSetup setup, ParameterDesk& desk, const std::atomic<bool>& heated)
      : setup_(std::move(setup)), desk_(desk), heated_(heated) {}

  /// Passes the file to the thread that changes the settings, through the desk's ReloadBox, which
  /// gets the answer later.
  void reload() const;

 private:
  void apply(const Reload& reload) const;

  ReloadSetup setup_;
  ParameterDesk& desk_;
  const std::atomic<bool>& heated_;
};

}  // namespace smaservo::daemon
