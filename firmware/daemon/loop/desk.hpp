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

/// Owns the daemon's settings in force and changes them while the loop runs: what is put is given
/// to the loop as a prepared set, and comes into force as a whole at the beginning of a cycle.
/// Given sets are numbered; each user of the settings remembers the number of the last one that it
/// has taken over. One thread changes them, see ReloadBox; any but the loop's may read a copy.
///
/// The loop refuses a set that it may not adopt while it heats. Once no other is under way, the
/// settings here are those in force again, with a new number.
class ParameterDesk final : public SettingsOwner<double> {
 public:
  ParameterDesk(const Settings<double>& settings, LoopLinks& links)
      : settings_(settings), in_line_{{0, settings}}, links_(links) {}
  ~ParameterDesk();
  ParameterDesk(const ParameterDesk&) = delete;
  ParameterDesk& operator=(const ParameterDesk&) = delete;

  /// The parameters that the loop begins with.
  ParameterSetPtr first() const { return make_parameter_set(settings_, 0); }

  // For the thread that changes the settings.

  const Settings<double>& settings() const override { return settings_; }
  /// False while the loop has refused a set and it is not known yet what holds, or while eight sets
  /// wait for the loop.
  bool has_room() const override { return !must_go_back_ && in_line_.size() <= max_under_way; }
  /// Takes settings that the next give() gives. Those before them that were not given are dropped.
  void put(const Settings<double>& settings) override;
  /// Gives the loop what was put and differs, as soon as there is room. Returns the number of the
  /// last set given.
  std::uint32_t give();
  /// put() and give(), if the settings were made from those with the number `from`, where one is
  /// given, and there is room. Returns whether that was so; otherwise try again later.
  bool change(const Settings<double>& settings, std::optional<std::uint32_t> from = std::nullopt);
  /// Deletes the parameters that the loop has replaced or refused, and takes the latter back.
  void tidy();

  // For any thread but the loop's.

  /// What the loop has refused since the last call, as text.
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
  Settings<double> settings_;     ///< those put last
  bool waits_ = false;            ///< they have not been given
  std::deque<Numbered> in_line_;  ///< the set in force, then those under way
  std::vector<std::string> refused_;
  bool must_go_back_ = false;  ///< one was refused
  ReloadBox reloads_;
  LoopLinks& links_;
  std::map<std::uint32_t, std::string> texts_;
  std::atomic<std::uint32_t> last_{0};
};

}  // namespace smaservo::daemon
