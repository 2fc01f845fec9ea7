#pragma once
// What SIGHUP asks for: the settings file anew.

#include <atomic>
#include <functional>
#include <string>
#include <vector>

#include "firmware/daemon/loop/desk.hpp"

namespace smaservo::daemon {

/// As a whole or not at all; what may change after a start only waits for it.
class Reloader {
 public:
  /// What keeps the board from settings; empty: nothing. None: no board does.
  using Problem = std::function<std::string(const Settings<double>&)>;

  /// Without a file there is nothing to read. Desk and `heated` outlive it.
  Reloader(std::string file, Problem problem, ParameterDesk& desk, const std::atomic<bool>& heated)
      : file_(std::move(file)), problem_(std::move(problem)), desk_(desk), heated_(heated) {}

  /// Why something is not changed, a sentence each.
  std::vector<std::string> reload() const;

 private:
  Settings<double> changed(const Settings<double>& before, const Settings<double>& from,
                           std::vector<std::string>& said) const;
  /// Empty: they are in force.
  std::string refused(const Settings<double>& to) const;

  std::string file_;
  Problem problem_;
  ParameterDesk& desk_;
  const std::atomic<bool>& heated_;
};

}  // namespace smaservo::daemon
