// The whole device as a microcontroller's main program calls it: in float, without heap or
// exceptions, one step each millisecond. Only the simulated wire, the settings file and the
// printing need a PC.

#include <cmath>
#include <fmt/format.h>

#include "firmware/device/device.hpp"
#include "firmware/parameters/parameters.hpp"
#include "firmware/text/settings_file.hpp"

using namespace smaservo;
using Model = Plant<ThreePhase<float>>;
namespace {
/// Replaces your registers: a wire under 0.68 N, and the current through it.
class Hardware {
 public:
  explicit Hardware(const Model::Params& wire) : wire_(wire) {}
  Inputs<float> read() {
    const float ohm = Model::resistance_ohm(wire_, state_, 298.15F);
    const float V = current_A_ * ohm;
    Model::advance(wire_, state_, {V * current_A_, 150e6F, 298.15F}, 1e-3F);
    Inputs<float> in{};
    in.fresh = true;  // false: no sample has come in this period
    in.sequence = ++sequence_;
    in.sample = {current_A_, V, 0.68F};
    in.supply_V = 24;
    in.ambient_K = in.driver_K = NAN;  // there are no such sensors
    return in;
  }
  void drive(float current_A) { current_A_ = current_A; }

 private:
  Model::Params wire_;
  Model::State state_ = Model::rest(wire_, {298.15F, 150e6F});
  float current_A_ = 0;
  std::uint32_t sequence_ = 0;
};
}  // namespace

int main() {
  // On a microcontroller the settings are in flash: firmware/parameters/store/store.hpp.
  const char* const file = "host-sim/scenarios/devices/smartflex-76um.toml";
  static const Prepared<float> prepared =
      prepare(stored_settings<float>(text::load_settings_file(file)));
  static Device<float>::State device = Device<float>::start();
  Hardware hardware(prepared.observer.model);
  fmt::print("time s  current A  strain %  temperature degC\n");
  for (int i = 1; i <= 3000; ++i) {
    Command<float> command{.fresh = true, .arm = true, .mode = Mode::strain};
    command.setpoint = i < 1500 ? 0.03F : 0.01F;
    const Output<float> out =
        Device<float>::step(prepared, device, hardware.read(), command, 1e-3F);
    hardware.drive(out.drive_current_A);
    if (i % 250 == 0) {
      fmt::print("{:6.2f}  {:9.3f}  {:8.2f}  {:16.1f}\n", i * 1e-3, out.drive_current_A,
                 100 * out.estimate.strain,
                 out.estimate.temperature_K - static_cast<float>(zero_degC_K));
    }
  }
}
