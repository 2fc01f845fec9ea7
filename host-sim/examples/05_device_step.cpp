// The whole device as a microcontroller's main program calls it: in float, without files, heap or
// exceptions, one step each millisecond. Only the simulated wire and the printing need a PC.
// smartflex_76um.hpp is made by `host-sim describe wire --wire smartflex-76um --as header`.

#include <cstdio>
#include <smaservo/firmware/device/servo.hpp>
#include <smaservo/firmware/parameters/parameters.hpp>
#include <smaservo/model/units.hpp>
#include <smaservo/model/wire/wire_plant.hpp>

#include "smartflex_76um.hpp"

using namespace smaservo;
namespace {

/// Every parameter has its default; what the wire's maker and your bench allow has none.
Settings<float> settings() {
  Settings<float> s = default_settings<float>();
  s.wire = wire_smartflex_76um<float>();
  s.measurement.current_full_scale_A = 0.5F;
  s.limits.min_current_A = 0.02F;
  s.limits.current_A = 0.4F;
  s.limits.power_W = 10;
  s.limits.temperature_K = 393.15F;
  s.limits.hot_spot_K = 18;
  s.limits.stress_Pa = 300e6F;
  s.trips.current_A = 0.45F;
  s.trips.temperature_K = 403.15F;
  s.trips.stress_Pa = 400e6F;
  return s;
}

}  // namespace

int main() {
  // What a microcontroller needs to be sure of before it heats anything.
  static Servo servo{settings()};
  static WirePlant wire{settings().wire, 0.68F};
  float current_A = 0;
  std::puts("time s  current A  strain %  temperature degC");
  for (int i = 1; i <= 3000; ++i) {
    // Your converters. A reading that could not be taken is NAN.
    const Sample<float> reading{.current_A = current_A,
                                .voltage_V = current_A * wire.output().resistance_ohm,
                                .load_N = 0.68F};
    const Output out =
        servo.update(reading, {.mode = Mode::strain, .setpoint = i < 1500 ? 0.03F : 0.01F}, 1e-3F);
    current_A = out.drive_current_A;  // to your current source
    wire.update({.current_A = current_A, .load_N = 0.68F}, 1e-3F);
    if (i % 250 == 0) {
      std::printf("%6.2f  %9.3f  %8.2f  %16.1f\n", i * 1e-3, static_cast<double>(current_A),
                  100 * static_cast<double>(out.estimate.strain),
                  static_cast<double>(out.estimate.temperature_K) - zero_degC_K);
    }
  }
}
