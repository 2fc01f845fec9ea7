#pragma once
// Tells whether a run was measured under one load.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "host-sim/identify/runs/run.hpp"

namespace smaservo::identify {

/// The value that this share of the values does not exceed.
inline double quantile(std::vector<double> values, double share) {
  std::ranges::sort(values);
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

/// Whether the stress stays within an eighth (and 5 MPa) of its median, except in up to a twentieth
/// of the rows above and as many below.
inline bool has_constant_stress(const Run& run) {
  const double middle_Pa = quantile(run.stress_Pa, 0.5);
  const double max_Pa = std::max(0.125 * std::abs(middle_Pa), 5e6);
  return quantile(run.stress_Pa, 0.05) >= middle_Pa - max_Pa &&
         quantile(run.stress_Pa, 0.95) <= middle_Pa + max_Pa;
}

}  // namespace smaservo::identify
