// Simulates a gripper: a wire closes its jaws against a spring. At 1.5 mm they meet an object.

#include <cmath>
#include <cstdio>
#include <smaservo/model/files/wire/wire_file.hpp>
#include <smaservo/model/units.hpp>
#include <smaservo/model/wire/wire_plant.hpp>

using namespace smaservo;
namespace {

constexpr double dt_s = 1e-3;
constexpr double spring_N = 0.5;        // with open jaws
constexpr double spring_N_m = 60;       // of the spring
constexpr double object_N_m = 2000;     // of the object
constexpr double object_at_m = 1.5e-3;  // contraction at which the jaws touch it

/// The force that spring and object need at this contraction.
double force_N(double contraction_m) {
  const double pressed_m = std::fmax(0, contraction_m - object_at_m);
  return spring_N + spring_N_m * contraction_m + object_N_m * pressed_m;
}

/// The force at which wire and jaws agree after this step. A wire under more force is longer, and
/// jaws that are less closed need less force: there is exactly one.
double balanced_N(const WirePlant<double>& plant, double current_A, double open_m,
                  double length_m) {
  double low = 0;
  double high = 20;
  for (int i = 0; i < 40; ++i) {
    const double load_N = 0.5 * (low + high);
    const double strain = plant.after({.current_A = current_A, .load_N = load_N}, dt_s).strain;
    (force_N(open_m - length_m * strain) < load_N ? high : low) = load_N;
  }
  return 0.5 * (low + high);
}

}  // namespace

int main() {
  // Presets are loaded by name; a file of your own is load_wire("mine.toml").
  const Wire<double> wire = files::load_wire("smartflex-76um").wire;
  const double length_m = wire.geometry.length_m;
  WirePlant plant{wire, spring_N};
  const double open_m = length_m * plant.output().strain;

  std::puts("time s  current A  temperature degC  closed mm  force N");
  for (int i = 0; i <= 4000; ++i) {
    const double current_A = i < 2000 ? 0.17 : 0;
    const double load_N = balanced_N(plant, current_A, open_m, length_m);
    const WireOutput now = plant.update({.current_A = current_A, .load_N = load_N}, dt_s);
    if (i % 250 == 0) {
      std::printf("%6.2f  %9.2f  %16.1f  %9.2f  %7.2f\n", i * dt_s, current_A,
                  now.temperature_K - zero_degC_K, 1e3 * (open_m - length_m * now.strain), load_N);
    }
  }
}
