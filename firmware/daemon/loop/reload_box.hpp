#pragma once
// Settings files that were read anew, on their way to the one thread that changes the settings: the
// bus's, or the main thread where there is no bus. Only one may change them, or each would take
// back what the other has just promised.

#include <atomic>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "firmware/settings.hpp"

namespace smaservo::daemon {

struct Reload {
  std::string file;
  Settings<double> settings;  ///< the file's
  /// Why settings are beyond the board; empty: they are not. A null function: there is no board.
  std::function<std::string(const Settings<double>&)> problem;
};

/// Each file gets one answer, in sentences for the log. Any thread may call.
class ReloadBox {
 public:
  void put(Reload reload) {
    const std::scoped_lock lock(mutex_);
    if (waiting_) {
      said_.push_back(waiting_->file + ": nothing is changed: the file was read once more");
    }
    waiting_ = std::move(reload);
  }
  std::optional<Reload> take() {
    const std::scoped_lock lock(mutex_);
    return std::exchange(waiting_, std::nullopt);
  }

  void say(const std::vector<std::string>& sentences) {
    const std::scoped_lock lock(mutex_);
    said_.insert(said_.end(), sentences.begin(), sentences.end());
  }
  std::vector<std::string> take_said() {
    const std::scoped_lock lock(mutex_);
    return std::exchange(said_, {});
  }

  /// The bus's thread takes what is put here, as long as it runs.
  void set_bus(bool serves) { bus_serves_.store(serves); }
  bool bus_serves() const { return bus_serves_.load(); }

 private:
  std::mutex mutex_;
  std::optional<Reload> waiting_;
  std::vector<std::string> said_;
  std::atomic<bool> bus_serves_{false};
};

}  // namespace smaservo::daemon
