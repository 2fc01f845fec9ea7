#pragma once
// The settings between the node, the desk and files that were read anew. All of it is called by the
// bus's thread, which is the only one that changes settings as long as there is a bus.

#include <cstdint>
#include <optional>

#include "firmware/canopen/servo/servo.hpp"
#include "firmware/daemon/loop/desk.hpp"
#include "firmware/daemon/service/reloader.hpp"

namespace smaservo::daemon {

class SettingsLink {
 public:
  SettingsLink(canopen::Servo<double>& servo, const Staging<double>& staging, ParameterDesk& desk,
               const LoopLinks& links)
      : servo_(servo), staging_(staging), desk_(desk), links_(links) {}

  /// Before each round of the bus. A file waits while something is being stored.
  void before_round(bool is_storing) {
    follow_desk();
    if (!is_storing) {
      take_reload();
    }
  }
  /// The store has what was in force; or it has been emptied.
  void note_stored(bool has_settings) { stored_ = has_settings; }
  /// For BusPump: gives what the node has put in force to the loop. False: again in the next round.
  bool give_to_desk() {
    const std::optional<std::uint32_t> number = desk_.change(staging_.active(), followed_);
    followed_ = number.value_or(followed_);
    return number.has_value();
  }

 private:
  /// The node gets the settings in force where the loop has refused what the node believes.
  void follow_desk() {
    const std::uint32_t changes = desk_.changes();
    if (followed_ != changes) {
      followed_ = changes;
      servo_.replace_settings(desk_.settings(), canopen::Source::device);
    }
  }

  /// A file is a write like one over the bus: after those that came before it, not while the loop
  /// has no room, in the log with old and new values.
  void take_reload() {
    if (servo_.holds_settings()) {
      return;
    }
    const std::optional<Reload> reload = desk_.reloads().take();
    if (!reload) {
      return;
    }
    if (stored_) {
      desk_.reloads().say(
          {reload->file + ": nothing is changed: settings were stored meanwhile, which go first"});
      return;
    }
    const bool heated = servo_.axis().may_heat() || links_.heated.load();
    const Reloaded read = reloaded(staging_.active(), *reload, heated);
    if (read.taken) {
      servo_.replace_settings(read.settings, canopen::Source::file);
    }
    desk_.reloads().say(read.said);
  }

  canopen::Servo<double>& servo_;
  const Staging<double>& staging_;
  ParameterDesk& desk_;
  const LoopLinks& links_;
  bool stored_ = false;         ///< in this run: whoever read a file did not see it
  std::uint32_t followed_ = 0;  ///< number of the desk's last change that the node has
};

}  // namespace smaservo::daemon
