#include "host-sim/replay/rows/reading_loop.hpp"

#include <utility>

#include "host-sim/replay/measurement_params.hpp"

namespace smaservo::replay {

ReadingLoop::ReadingLoop(const Wire<double>& wire, RunSettings settings,
                         std::vector<std::string> observers)
    : wire_(wire),
      settings_(std::move(settings)),
      names_(std::move(observers)),
      sensors_(measurement_params(wire_, settings_)) {
  for (const std::string& name : names_) {
    require_observer(name);
  }
}

bool ReadingLoop::add(const Sample<double>& reading, const Place& place) {
  measurement_ = measure(sensors_, reading);
  const double dt_s = static_cast<double>(place.time_ns - last_ns_) * 1e-9;
  last_ns_ = place.time_ns;
  if (running_.empty() || dt_s > longest_gap_s || place.piece != piece_) {
    const bool again = !running_.empty();
    piece_ = place.piece;
    start(place.ambient_K);
    return again;
  }
  for (const auto& observer : running_) {
    observer->advance(measurement_, dt_s);
  }
  return false;
}

void ReadingLoop::start(double ambient_K) {
  running_.clear();
  for (const std::string& name : names_) {
    running_.push_back(make_observer(name, wire_, settings_, measurement_, ambient_K));
  }
}

}  // namespace smaservo::replay
