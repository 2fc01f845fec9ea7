#pragma once

#include <atomic>
#include <cstdint>
#include <deque>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "firmware/daemon/loop/links.hpp"
#include "firmware/daemon/loop/reload_box.hpp"
#include "firmware/parameters/settings_owner.hpp"

namespace smaservo::daemon {

/// Owns the daemon's settings in force and changes them while the loop runs. New settings are
/// passed to put(); give() then sends them to the loop as a prepared set, which comes into force as
/// a whole at the beginning of a cycle. Sets that were sent are numbered; each user of the settings
/// remembers the number of the last set that it has taken over. Only one thread changes the
/// settings (see ReloadBox); any thread but the loop's may read a copy.
///
/// The loop refuses a set that it may not adopt while it heats. After that, when no other set is on
/// its way to the loop, settings() are again those in force, with a new number.
class ParameterDesk final : public SettingsOwner<double> {
 public:
  ParameterDesk(const Settings<double>& settings, LoopLinks& links)
      : settings_(settings), in_line_{{0, settings}}, links_(links) {}
  ~ParameterDesk();
  ParameterDesk(const ParameterDesk&) = delete;
  ParameterDesk& operator=(const ParameterDesk&) = delete;

  /// The set with which the loop begins.
  ParameterSetPtr first() const { return make_parameter_set(settings_, 0); }

  // For the thread that changes the settings.

  const Settings<double>& settings() const override { return settings_; }
  /// False from the refusal of a set until the settings in force are known again, and while eight
  /// sets wait for the loop.
  bool has_room() const override { return !must_go_back_ && in_line_.size() <= max_under_way; }
  /// Stores settings for the next give(). Earlier ones that were not given yet are dropped.
  void put(const Settings<double>& settings) override;
  /// Gives the loop the settings of put(), if they differ from those given last and there is room.
  /// Returns the number of the last set given.
  std::uint32_t give();
  /// Does put() and give() if there is room; with `from`, the number of the set from which the
  /// settings were made, only if no other set was given since. Returns whether it was done; if not,
  /// try again later.
  bool change(const Settings<double>& settings, std::optional<std::uint32_t> from = std::nullopt);
  /// Deletes the sets that the loop has replaced or refused. After a refusal the settings go back
  /// to those in force.
  void tidy();

  // For any thread but the loop's.

  /// Returns the changes that the loop has refused since the last call, as text.
  std::vector<std::string> take_refused();
  ReloadBox& reloads() { return reloads_; }

  Settings<double> copy() const;
  /// The number of the last set given.
  std::uint32_t changes() const { return last_.load(); }
  /// Returns the text of a change for the recording, and forgets it.
  std::string take_text(std::uint32_t number);

 private:
  static constexpr int max_under_way = 8;
  struct Numbered {
    std::uint32_t number;
    Settings<double> settings;
  };

  std::uint32_t give_locked();
  void delete_old();
  void take_back(std::uint32_t number);

  mutable std::mutex mutex_;
  Settings<double> settings_;     ///< the settings put last
  bool waits_ = false;            ///< settings_ have not been given
  std::deque<Numbered> in_line_;  ///< the set in force, then those on their way to the loop
  std::vector<std::string> refused_;
  bool must_go_back_ = false;  ///< a set was refused, and settings_ are not yet those in force
  ReloadBox reloads_;
  LoopLinks& links_;
  std::map<std::uint32_t, std::string> texts_;
  std::atomic<std::uint32_t> last_{0};
};

}  // namespace smaservo::daemon
