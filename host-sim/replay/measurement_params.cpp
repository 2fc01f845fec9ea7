#include "host-sim/replay/measurement_params.hpp"

#include "observer/estimator.hpp"

namespace smaservo::replay {

MeasurementParams<double> measurement_params(const Wire<double>& wire,
                                             const RunSettings& settings) {
  return with_settings(good_front_end(wire), settings);
}

}  // namespace smaservo::replay
