#include "host-sim/tune/bench.hpp"

#include <limits>

namespace smaservo::tune {

TunedBench::TunedBench(const TunedPlant& plant, double current_noise_A, double voltage_noise_V)
    : plant_(plant),
      params_(lumped_params(plant)),
      state_(LumpedModel::rest(params_, {plant.ambient_K, plant.load.low_Pa})),
      rest_strain_(strain()),
      current_noise_A_(current_noise_A),
      voltage_noise_V_(voltage_noise_V),
      stress_Pa_(plant.load.low_Pa) {}

Inputs<double> TunedBench::inputs() {
  Inputs<double> in{};
  in.fresh = true;
  in.sequence = sequence_++;
  const double noise_A = current_noise_A_ * normal_(random_);
  const double noise_V = voltage_noise_V_ * normal_(random_);
  in.sample = {current_A_ + noise_A, current_A_ * ohm() + noise_V,
               stress_Pa_ * plant_.wire.geometry.area_m2()};
  in.supply_V = std::numeric_limits<double>::quiet_NaN();
  in.ambient_K = plant_.ambient_K;
  in.driver_K = std::numeric_limits<double>::quiet_NaN();
  return in;
}

void TunedBench::drive(double current_A, double dt_s) {
  current_A_ = current_A;
  const double power_W = current_A * current_A * ohm();
  stress_Pa_ = advance_loaded(plant_, params_, state_, power_W, rest_strain_, dt_s);
}

}  // namespace smaservo::tune
