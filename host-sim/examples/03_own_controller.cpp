// Holds a strain with a proportional controller of one's own, which uses the observer's estimate.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <smaservo/model/files/wire/wire_file.hpp>
#include <smaservo/model/wire/wire_plant.hpp>
#include <smaservo/observer/estimator.hpp>

using namespace smaservo;

int main() {
  constexpr double dt_s = 1e-3;
  constexpr double load_N = 0.68;
  // Always flows, since the resistance cannot be measured without it.
  constexpr double sense_A = 0.012;
  constexpr double max_A = 0.2;  // the converter's maximum

  // The simulated wire is also the observer's model.
  const Wire<double> wire = files::load_wire("smartflex-76um").wire;
  WirePlant plant{wire, load_N};
  Estimator estimator{wire};

  std::puts("time s  wanted %  estimate %  strain %  power W");
  double power_W = 0;
  for (int i = 0; i <= 4000; ++i) {
    const WireOutput real = plant.output();
    const double current_A = std::clamp(std::sqrt(power_W / real.resistance_ohm), sense_A, max_A);
    const Estimate now = estimator.update(
        {.current_A = current_A, .voltage_V = current_A * real.resistance_ohm, .load_N = load_N},
        dt_s);

    // A wire that is too long needs heat. The heat that holds it comes from a remaining error.
    const double wanted = i < 2000 ? 0.02 : 0.03;
    power_W = std::clamp(100 * (now.strain - wanted), 0.0, 1.0);

    if (i % 500 == 499) {
      std::printf("%6.2f  %8.2f  %10.2f  %8.2f  %7.3f\n", i * dt_s, 100 * wanted, 100 * now.strain,
                  100 * real.strain, power_W);
    }
    plant.update({.current_A = current_A, .load_N = load_N}, dt_s);
  }
}
