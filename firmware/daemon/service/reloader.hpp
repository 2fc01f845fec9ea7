#pragma once
// Reads the settings file anew, which SIGHUP asks for.

#include <atomic>
#include <functional>
#include <string>
#include <vector>

#include "firmware/daemon/loop/desk.hpp"

namespace smaservo::daemon {

/// Changes the settings as a whole or not at all. Parameters that can not change now, but only with
/// the next start or without heat, keep their values.
class Reloader {
 public:
  /// Says why settings are beyond the board; empty: they are not. A null function: there is no
  /// board.
  using Problem = std::function<std::string(const Settings<double>&)>;

  /// `file` empty: there is nothing to read. `desk` and `heated` must outlive the reloader.
  Reloader(std::string file, Problem problem, ParameterDesk& desk, const std::atomic<bool>& heated)
      : file_(std::move(file)), problem_(std::move(problem)), desk_(desk), heated_(heated) {}

  /// Returns a sentence for each thing that was not changed: why.
  std::vector<std::string> reload() const;

 private:
  Settings<double> changed(const Settings<double>& before, const Settings<double>& from,
                           std::vector<std::string>& said) const;
  /// Why the settings are refused; empty: they are in force.
  std::string refused(const Settings<double>& to) const;

  std::string file_;
  Problem problem_;
  ParameterDesk& desk_;
  const std::atomic<bool>& heated_;
};

}  // namespace smaservo::daemon
