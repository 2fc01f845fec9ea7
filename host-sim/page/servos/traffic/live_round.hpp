#pragma once
// The polling of one servo's live values, where they do not come by SYNC: which of them are read in
// one round, and what of a round has been read.

#include <vector>

#include "host-sim/page/servos/history.hpp"

namespace smaservo::page {

struct PolledSignals {
  std::vector<std::size_t> fast, slow;  ///< signals of each round; one of these in each
};

/// Which signals are polled in each round. Where the bus has room, these are all of them at the
/// promised rate. Where it has not, the signals that a page shows first are polled in every round,
/// and the others take turns, one a round. Where the servo sends signals by SYNC (`by_sync`), these
/// are not polled, and all others take turns. `requests_per_s` is the number of requests for
/// live values that the bus has room for, of this servo.
PolledSignals polled_signals(double requests_per_s, const SignalSet* by_sync);

class LiveRound {
 public:
  bool is_running() const { return running_; }
  /// Whether it is time for another round.
  bool is_due(std::int64_t now_us) const { return now_us >= due_us_; }
  /// Begins a round, if there is any signal to read.
  void begin(PolledSignals signals, std::int64_t now_us);
  /// The signal that is to be read next; only of a round that runs.
  std::size_t next();

  /// Samples that an answer has completed.
  struct Completed {
    std::optional<Sample> fast, slow;
  };
  /// Takes the value of the signal that was asked for last; none if it has not come.
  Completed take(std::optional<float> value, std::int64_t now_us);

  /// Ends the round, and the time until the next one is no gap.
  void stop();
  /// Number of samples that have been missing.
  std::uint64_t gaps() const { return gaps_; }

 private:
  PolledSignals signals_;
  std::size_t at_ = 0,
              slow_at_ = 0;  ///< number of requests of the round; place among the slow ones
  std::size_t asked_ = 0;    ///< the signal that was asked for last
  bool running_ = false;
  std::int64_t due_us_ = 0, last_us_ = 0;
  Sample fast_, slow_;
  std::uint64_t gaps_ = 0;
};

/// Samples a second, by SYNC or polled.
class SampleRate {
 public:
  /// Counts a sample; returns the rate once a second.
  std::optional<double> count(std::int64_t now_us);

 private:
  std::int64_t since_us_ = 0;
  unsigned count_ = 0;
};

}  // namespace smaservo::page
