// Holds a strain with a proportional controller of one's own, which uses the observer's estimate.

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

#include "model/files/wire/wire_file.hpp"
#include "observer/measurement.hpp"
#include "observer/multiple_model.hpp"

using Model = smaservo::Plant<smaservo::ThreePhase<double>>;
using Observer = smaservo::MultipleModelFilter<double>;

int main() {
  using namespace smaservo;
  constexpr double ambient_K = 298.15;
  constexpr double stress_Pa = 150e6;
  constexpr double dt_s = 1e-3;
  // Always flows, since the resistance cannot be measured without it.
  constexpr double sense_A = 0.012;
  constexpr double max_A = 0.2;  // the converter's maximum

  // The simulated wire is also the observer's model.
  const Wire<double> wire = files::load_wire("smartflex-76um").wire;
  const Model::Params plant = plant_params(wire);
  Model::State state = Model::rest(plant, {ambient_K, stress_Pa});

  // Area, two offsets, two noises, lead resistance, least current, and the range of the resistance.
  const double cold_ohm = cold_resistance_ohm(wire);
  const MeasurementParams<double> sensors{
      wire.geometry.area_m2(), 0, 0, 1e-5, 3e-4, 0, 0.005, 0.5 * cold_ohm, 2 * cold_ohm};
  const Observer::Params model{plant, kalman_tuning(wire.accuracy)};
  Observer::State observer{};

  fmt::print("time s  wanted %  estimate %  strain %  power W\n");
  double power_W = 0;
  for (int i = 0; i <= 4000; ++i) {
    const double ohm = Model::resistance_ohm(plant, state, ambient_K);
    const double current_A = std::clamp(std::sqrt(power_W / ohm), sense_A, max_A);
    const Measurement<double> m =
        measure<double>(sensors, {current_A, current_A * ohm, stress_Pa * sensors.area_m2});
    if (i == 0) {
      Observer::start(model, observer, m, ambient_K);
    } else {
      Observer::advance(model, observer, m, dt_s);
    }
    const double strain = Observer::estimate(model, observer).strain;

    // A wire that is too long needs heat. The heat that holds it comes from a remaining error.
    const double wanted = i < 2000 ? 0.02 : 0.03;
    power_W = std::clamp(100 * (strain - wanted), 0.0, 1.0);

    if (i % 500 == 499) {
      fmt::print("{:6.2f}  {:8.2f}  {:10.2f}  {:8.2f}  {:7.3f}\n", i * dt_s, 100 * wanted,
                 100 * strain, 100 * Model::strain(plant, state), power_W);
    }
    Model::advance(plant, state, {current_A * current_A * ohm, stress_Pa, ambient_K}, dt_s);
  }
}
