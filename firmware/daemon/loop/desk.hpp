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
#include "firmware/parameters/parameter_check.hpp"

namespace smaservo::daemon {

/// Owns the daemon's settings in force and changes them while the loop runs: a change is prepared
/// here, and comes into force as a whole at the beginning of a cycle. Changes are numbered; each
/// user of the settings remembers the number of the last change it has taken over. One thread
/// changes them, see ReloadBox; any but the loop's may read.
///
/// The loop refuses a set that it may not adopt while it heats. Once no other is under way, the
/// settings here are those in force again, with a new number.
class ParameterDesk {
 public:
  ParameterDesk(const Settings<double>& settings, LoopLinks& links)
      : settings_(settings), in_line_{{0, settings}}, links_(links) {}
  ~ParameterDesk();
  ParameterDesk(const ParameterDesk&) = delete;
  ParameterDesk& operator=(const ParameterDesk&) = delete;

  /// The parameters that the loop begins with.
  ParameterSetPtr first() const { return make_parameter_set(settings_, 0); }

  /// Puts settings in force, which must have passed check(), and which were made from those of the
  /// change with the number `from`, if one is given. Returns the change's number, or the last one's
  /// where nothing changes. nullopt: the settings have changed since `from`, the loop has refused
  /// some and it is not known yet what holds, or too many changes wait for it. Try again later.
  std::optional<std::uint32_t> change(const Settings<double>& settings,
                                      std::optional<std::uint32_t> from = std::nullopt);

  /// Deletes the parameters that the loop has replaced or refused.
  void tidy();
  /// What the loop has refused since the last call, as text.
  std::vector<std::string> take_refused();
  ReloadBox& reloads() { return reloads_; }

  /// The settings given last, and the number of changes so far.
  Settings<double> settings() const;
  std::uint32_t changes() const { return last_.load(); }
  /// Returns the text of a change for the recording, and forgets it.
  std::string take_text(std::uint32_t number);

 private:
  static constexpr int max_under_way = 8;
  struct Numbered {
    std::uint32_t number;
    Settings<double> settings;
  };

  void delete_old();
  void take_back(std::uint32_t number);

  mutable std::mutex mutex_;
  Settings<double> settings_;
  std::deque<Numbered> in_line_;  ///< the set in force, then those under way
  std::vector<std::string> refused_;
  bool must_go_back_ = false;  ///< one was refused
  ReloadBox reloads_;
  LoopLinks& links_;
  std::map<std::uint32_t, std::string> texts_;
  std::atomic<std::uint32_t> last_{0};
};

}  // namespace smaservo::daemon
