// Heats a simulated wire by a step of the current, and lets it cool.

#include <fmt/format.h>

#include "model/files/wire/wire_file.hpp"
#include "model/units.hpp"
#include "model/wire/plant.hpp"
#include "model/wire/three_phase/three_phase.hpp"

// A wire of one temperature that transforms by the three-phase model, computed in double precision.
using Model = smaservo::Plant<smaservo::ThreePhase<double>>;

int main() {
  using namespace smaservo;
  constexpr double ambient_K = 298.15;
  constexpr double stress_Pa = 150e6;
  constexpr double dt_s = 1e-3;

  // Presets are loaded by name; a file of your own is load_wire("mine.toml").
  const Model::Params wire = plant_params(files::load_wire("smartflex-76um").wire);
  Model::State state = Model::rest(wire, {ambient_K, stress_Pa});

  fmt::print("time s  current A  temperature degC  strain %  resistance ohm\n");
  for (int i = 0; i <= 3000; ++i) {
    const double current_A = i < 1500 ? 0.17 : 0;
    const double ohm = Model::resistance_ohm(wire, state, ambient_K);
    if (i % 250 == 0) {
      fmt::print("{:6.2f}  {:9.2f}  {:16.1f}  {:8.2f}  {:14.2f}\n", i * dt_s, current_A,
                 Model::temperature_K(state) - zero_degC_K, 100 * Model::strain(wire, state), ohm);
    }
    Model::advance(wire, state, {current_A * current_A * ohm, stress_Pa, ambient_K}, dt_s);
  }
}
