#pragma once
// What a replay makes of each row of current, voltage and load, wherever the rows come from.

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "host-sim/replay/observers.hpp"
#include "host-sim/replay/run_settings.hpp"
#include "model/wire/wire.hpp"
#include "observer/measurement.hpp"

namespace smaservo::replay {

/// Measures each row and gives it to observers, which start again after a gap and with each new
/// piece of a trace, because what happened there is unknown.
class ReadingLoop {
 public:
  /// After a longer time without a row the observers start again.
  static constexpr double longest_gap_s = 60;

  /// The first observer is the one of estimate(). Throws UserError for a name that does not exist.
  ReadingLoop(const Wire<double>& wire, RunSettings settings, std::vector<std::string> observers);

  /// When and where a row was read.
  struct Place {
    std::int64_t time_ns;
    std::uint32_t piece;  ///< hal::TraceRow::piece
    double ambient_K;     ///< used if the observers start with this row
  };
  /// Takes a row; times must rise. Returns true if the observers started again with it, which does
  /// not include the first row.
  bool add(const Sample<double>& reading, const Place& place);

  /// Of the row that was added last.
  const Measurement<double>& measurement() const { return measurement_; }
  Estimate<double> estimate(std::size_t observer = 0) const {
    return running_[observer]->estimate();
  }
  const MeasurementParams<double>& sensors() const { return sensors_; }

 private:
  void start(double ambient_K);

  Wire<double> wire_;
  RunSettings settings_;
  std::vector<std::string> names_;
  MeasurementParams<double> sensors_;
  std::vector<std::unique_ptr<AnyObserver>> running_;
  Measurement<double> measurement_{};
  std::int64_t last_ns_ = 0;
  std::uint32_t piece_ = 0;
};

}  // namespace smaservo::replay
