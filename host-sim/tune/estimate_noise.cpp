#include "host-sim/tune/estimate_noise.hpp"

#include <cmath>
#include <random>

#include "firmware/device/device.hpp"
#include "host-sim/tune/bench.hpp"

namespace smaservo::tune {

double estimate_noise(const TunedPlant& plant, const Proposal& p) {
  const Prepared<double> prepared = prepare(p.settings);
  const double dt_s = p.settings.timing.period_s;
  const OperatingPoint& middle = p.branches.points[4];
  TunedBench bench(plant, 0, 0);
  Device<double>::State clean = Device<double>::start();
  Device<double>::State noisy = clean;
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal;
  double sum = 0, square = 0;
  int counted = 0;
  const double reach_s = 5 * middle.capacity_J_K / middle.loss_slope_W_K;
  const int reached = static_cast<int>(std::min(reach_s, 60.0) / dt_s);
  const int last = reached + static_cast<int>(2 / dt_s);
  for (int i = 0; i < last; ++i) {
    Inputs<double> in = bench.inputs();
    Device<double>::observe(prepared, clean, in, dt_s);
    in.sample.current_A += p.settings.measurement.current_noise_A * normal(random);
    in.sample.voltage_V += p.settings.measurement.voltage_noise_V * normal(random);
    Device<double>::observe(prepared, noisy, in, dt_s);
    if (reached <= i) {
      const double off = Device<double>::estimate(prepared, noisy).strain -
                         Device<double>::estimate(prepared, clean).strain;
      sum += off;
      square += off * off;
      ++counted;
    }
    bench.drive(std::sqrt(middle.loss_W / bench.ohm()), dt_s);
  }
  const double mean = sum / counted;
  return std::sqrt(std::max(0.0, square / counted - mean * mean));
}

}  // namespace smaservo::tune
