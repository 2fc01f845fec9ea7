#include "host-sim/replay/measurement_params.hpp"

#include "model/wire/plant.hpp"

namespace smaservo::replay {

MeasurementParams<double> measurement_params(const Wire<double>& wire,
                                             const RunSettings& settings) {
  const double ohm = cold_resistance_ohm(wire);
  const double limit_A = wire.limits.current_A;
  const MeasurementParams<double> p{
      wire.geometry.area_m2(), 0,         0,        1e-4 * limit_A, 1e-4 * limit_A * ohm, 0,
      0.03 * limit_A,          0.5 * ohm, 2.0 * ohm};
  return with_settings(p, settings);
}

}  // namespace smaservo::replay
