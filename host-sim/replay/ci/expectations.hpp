#pragma once
// The file of --expect: bounds for each trace.

#include <map>
#include <span>
#include <string>

#include "host-sim/replay/ci/bounds.hpp"

namespace smaservo::replay {

class Expectations {
 public:
  /// Reads the file for these traces and observers. Throws ConfigError, also for a trace of the
  /// file that is not among them, which would never be judged, and for one of them that the file
  /// has no bounds for.
  Expectations(const std::string& file, std::span<const std::string> traces,
               std::span<const std::string> observers);

  const Bounds& of(const std::string& trace) const;

 private:
  std::map<std::string, Bounds> by_name_;
};

}  // namespace smaservo::replay
