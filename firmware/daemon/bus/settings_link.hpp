#pragma once
// Passes settings between the node, the desk and files that were read anew. All functions are
// called by the bus's thread, which is the only one that changes settings while there is a bus.

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

  /// To be called before each round of the bus. A file has to wait while a store is in progress.
  void before_round(bool is_storing) {
    desk_.tidy();
    follow_desk();
    if (!is_storing) {
      take_reload();
    }
  }
  /// To be called after a store: whether the store has the settings, or has been emptied.
  void note_stored(bool has_settings) { stored_ = has_settings; }
  /// For BusPump: gives the loop the settings that the node has put in force.
  void give() { followed_ = desk_.give(); }

 private:
  /// Tells the node of settings that it has not put in force itself, as when the loop has refused
  /// those of the node.
  void follow_desk() {
    const std::uint32_t changes = desk_.changes();
    if (followed_ != changes) {
      followed_ = changes;
      servo_.replace_settings(desk_.copy(), canopen::Source::device);
    }
  }

  /// Treats a settings file like a write over the bus: it comes after earlier writes, waits while
  /// the loop has no room, and is logged with old and new values.
  void take_reload() {
    if (!desk_.has_room()) {
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
  /// Settings were stored in this run, unknown to the reader of a waiting file.
  bool stored_ = false;
  std::uint32_t followed_ = 0;  ///< number of the desk's last change that the node has
};

}  // namespace smaservo::daemon
