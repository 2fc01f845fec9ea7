#pragma once
// The polling of one servo's live values, if they do not come by SYNC: the signals to read in a
// round, and the progress of the round.

#include <vector>

#include "host-sim/page/servos/history.hpp"

namespace smaservo::page {

struct PolledSignals {
  std::vector<std::size_t> fast, slow;  ///< read in each round: all of `fast`, one of `slow`
};

/// Chooses the signals to poll in each round. If the bus has room for it, each round polls all
/// signals at the promised rate. Otherwise each round polls the signals that a page shows first,
/// and one of the others in turn. Signals that the servo sends by SYNC (`by_sync`) are not polled,
/// and then all others take turns. `requests_per_s` is the number of requests for live values of
/// this servo that the bus has room for.
PolledSignals polled_signals(double requests_per_s, const SignalSet* by_sync);

class LiveRound {
 public:
  bool is_running() const { return running_; }
  /// Whether it is time for another round.
  bool is_due(std::int64_t now_us) const { return now_us >= due_us_; }
  /// Begins a round, if there is any signal to read.
  void begin(PolledSignals signals, std::int64_t now_us);
  /// The signal to read next. To be called only while a round runs.
  std::size_t next();

  /// Samples that an answer has completed.
  struct Completed {
    std::optional<Sample> fast, slow;
  };
  /// Takes the value of the signal that was requested last; none if no answer has come.
  Completed take(std::optional<float> value, std::int64_t now_us);

  /// Ends the round. The time until the next one does not count as a gap.
  void stop();
  /// Number of missing samples so far.
  std::uint64_t gaps() const { return gaps_; }

 private:
  PolledSignals signals_;
  std::size_t at_ = 0,
              slow_at_ = 0;  ///< number of requests of this round so far; place among `slow`
  std::size_t asked_ = 0;    ///< the signal that was requested last
  bool running_ = false;
  std::int64_t due_us_ = 0, last_us_ = 0;
  Sample fast_, slow_;
  std::uint64_t gaps_ = 0;
};

/// Measures the number of samples per second, polled or by SYNC.
class SampleRate {
 public:
  /// Counts a sample; returns the rate once a second.
  std::optional<double> count(std::int64_t now_us);

 private:
  std::int64_t since_us_ = 0;
  unsigned count_ = 0;
};

}  // namespace smaservo::page
