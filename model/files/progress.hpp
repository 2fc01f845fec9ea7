#pragma once
// What long work shows of itself on the standard error output, beginning after a moment, so that
// short work shows nothing.

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>
#include <utility>

namespace smaservo::files {

/// A time as people say it: "45 s", "12 min", "1 h 05 min".
std::string duration_text(double seconds);

/// Until the next line of a log, after work has taken so long: else long work would write thousands
/// of lines.
std::chrono::milliseconds pause_in_a_log(std::chrono::milliseconds elapsed);

/// The text of a moment: "fit: 34 %, 2 min left". While nothing is done there is no forecast:
/// "fit: 12 s so far".
class Forecast {
 public:
  /// `share` done, 0 to 1, after `elapsed_s`. Large parts end seldom: while the share stays as it
  /// is, the time left goes on falling; when it has passed, "fit: 34 %, longer than expected".
  std::string text(std::string_view what, double share, double elapsed_s);

 private:
  double share_ = 0, whole_s_ = 0;
};

/// Shows the share that is done and the time left: on a terminal as one line that is redrawn after
/// half a second and then each second, and removed at the end; elsewhere, as in the log of
/// continuous integration, as a line every 10 s, and of work that takes longer than five minutes
/// every thirtieth of the time so far. A thread of its own shows it, so that it is shown
/// also while one long part goes on.
class Progress {
 public:
  /// `total` 0: the amount of work is not known, and `done` counts bytes.
  Progress(std::string what, std::uint64_t total);
  /// For work of which the share is known: update_share().
  explicit Progress(std::string what) : Progress(std::move(what), parts) {}
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// Less than before has no effect. Costs next to nothing; to be called by one thread at a time.
  void update(std::uint64_t done) {
    if (done_.load(std::memory_order_relaxed) < done) {
      done_.store(done, std::memory_order_relaxed);
    }
  }
  /// 0 to 1.
  void update_share(double share) { update(static_cast<std::uint64_t>(parts * share)); }
  /// Renames the work, for a part of it. May be called by any thread.
  void name(std::string what);

 private:
  static constexpr std::uint64_t parts = 1'000'000;

  std::string text(Forecast& forecast, double elapsed_s) const;
  void show(const std::stop_token& stop) noexcept;

  std::mutex mutex_;
  std::string what_;
  std::uint64_t total_;
  std::atomic<std::uint64_t> done_ = 0;
  std::condition_variable_any wakes_;
  std::jthread thread_;  // last: it uses all others
};

}  // namespace smaservo::files
