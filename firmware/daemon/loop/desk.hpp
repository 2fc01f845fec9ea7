#pragma once

#include <atomic>
#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <string>

#include "firmware/daemon/loop/links.hpp"
#include "firmware/parameters/parameter_check.hpp"

namespace smaservo::daemon {

/// Owns the daemon's settings in force and changes them while the loop runs: a change is prepared
/// here, and comes into force as a whole at the beginning of a cycle. Changes are numbered; each
/// user of the settings remembers the number of the last change it has taken over. Any thread but
/// the loop's may use it.
class ParameterDesk {
 public:
  ParameterDesk(const Settings<double>& settings, LoopLinks& links)
      : settings_(settings), links_(links) {}
  ~ParameterDesk();
  ParameterDesk(const ParameterDesk&) = delete;
  ParameterDesk& operator=(const ParameterDesk&) = delete;

  /// The parameters that the loop begins with.
  ParameterSetPtr first() const { return make_parameter_set(settings_, 0); }

  /// Puts settings in force, which must have passed check(). Returns the change's number, or the
  /// last one's where nothing changes. nullopt: too many changes still wait for the loop, try again
  /// later.
  std::optional<std::uint32_t> change(const Settings<double>& settings);

  /// Deletes the parameters that the loop has replaced.
  void tidy();

  /// The settings given last, and the number of changes so far.
  Settings<double> settings() const;
  std::uint32_t changes() const { return last_.load(); }
  /// Returns the text of a change for the recording, and forgets it.
  std::string take_text(std::uint32_t number);

 private:
  static constexpr int max_under_way = 8;

  void delete_old();

  mutable std::mutex mutex_;
  Settings<double> settings_;
  LoopLinks& links_;
  std::map<std::uint32_t, std::string> texts_;
  std::atomic<std::uint32_t> last_{0};
  int under_way_ = 0;
};

}  // namespace smaservo::daemon
