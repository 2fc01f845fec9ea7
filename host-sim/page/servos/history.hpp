#pragma once
// The live samples of one servo in a bounded memory.
//
// Rows with the same signals are stored together in chunks. A row takes 8 + 4 n bytes with n
// signals: ten minutes take 24 MB at 1 kHz with 8 signals, 5 MB at 80 Hz with all 24. If more than
// `max_bytes` would be needed, the oldest rows are dropped first.

#include <bitset>
#include <cstdint>
#include <deque>
#include <mutex>
#include <optional>
#include <vector>

#include "firmware/signals.hpp"

namespace smaservo::page {

/// The signals of 2200h that a sample contains, by row of signal_rows.
using SignalSet = std::bitset<signal_count>;

struct Sample {
  std::int64_t time_us = 0;  ///< time on the bus's clock
  SignalSet has;
  Signals values{};
};

/// Rows of all signals; NaN if a row does not contain the signal.
struct HistoryRows {
  std::vector<std::int64_t> time_us;
  SignalSet has;
  std::vector<std::vector<float>> columns;  ///< one column for each signal of `has`, in their order
};

class History {
 public:
  static constexpr std::int64_t longest_us = 600'000'000;
  static constexpr std::size_t max_bytes = 26'000'000;

  /// Both may be called from any thread. Samples must come in the order of their times.
  void add(const Sample& sample);
  /// The last rows: all of them if they are at most `points`, otherwise the least and greatest
  /// value of each signal in each of points / 2 equal parts of the time, in their order: no peak is
  /// lost, and none is moved by more than such a part.
  HistoryRows last(std::int64_t span_us, std::size_t points) const;

  std::size_t bytes() const;
  std::optional<Sample> newest() const;

 private:
  static constexpr std::size_t chunk_rows = 1024;
  struct Chunk {
    SignalSet has;
    std::vector<std::int64_t> times_us;
    std::vector<float> values;  ///< row by row
  };
  static std::size_t bytes_of(const Chunk& chunk);
  Chunk& open_chunk(const SignalSet& has);
  void drop_old(std::int64_t now_us);
  template <class Use>
  void for_each_row(std::int64_t from_us, Use use) const;
  HistoryRows whole(std::int64_t from_us, const SignalSet& has) const;
  HistoryRows thinned(std::int64_t from_us, const SignalSet& has, std::size_t points) const;

  mutable std::mutex mutex_;
  std::deque<Chunk> chunks_;  ///< sorted by the time of their first rows
  std::size_t bytes_ = 0;
  Sample newest_;
};

}  // namespace smaservo::page
