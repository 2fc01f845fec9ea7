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

/// The owner of a daemon's settings in force, and where they change while the loop runs: prepared
/// here, in force there as a whole at the beginning of a cycle. Whoever uses them keeps the number
/// that it has followed. For any thread but the loop's.
class ParameterDesk {
 public:
  ParameterDesk(const Settings<double>& settings, LoopLinks& links)
      : settings_(settings), links_(links) {}
  ~ParameterDesk();
  ParameterDesk(const ParameterDesk&) = delete;
  ParameterDesk& operator=(const ParameterDesk&) = delete;

  /// For the loop to begin with.
  ParameterSetPtr first() const { return make_parameter_set(settings_, 0); }

  /// Settings that have passed check(); the number of what is then in force. Nothing: too many are
  /// under way, try again later. Nothing happens where nothing changes.
  std::optional<std::uint32_t> change(const Settings<double>& settings);

  /// Deletes what the loop has given back.
  void tidy();

  /// Those given last, and how often some have been given.
  Settings<double> settings() const;
  std::uint32_t changes() const { return last_.load(); }
  /// What a set changed, as a recording says it; forgets it.
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
