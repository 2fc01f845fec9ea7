// A program outside of the tree: model, observer, device, wire files, settings files and
// recordings.
//   program TRACE.csv WIRE.toml SPREADSHEET.xlsx

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <smaservo/firmware/device/device.hpp>
#include <smaservo/firmware/parameters/parameters.hpp>
#include <smaservo/firmware/text/device_names.hpp>
#include <smaservo/firmware/text/settings_file.hpp>
#include <smaservo/hal/replay/board.hpp>
#include <smaservo/model/files/error.hpp>
#include <smaservo/model/files/wire/wire_file.hpp>
#include <smaservo/model/wire/plant.hpp>
#include <smaservo/observer/measurement.hpp>
#include <smaservo/observer/multiple_model.hpp>
#include <smaservo/observer/substepping.hpp>
#include <string>
#include <utility>

#include "firmware/settings.hpp"
#include "model/units.hpp"

using namespace smaservo;

namespace {

/// Heats a wire by 0.17 A for 1.5 s.
void heat() {
  using Model = Plant<ThreePhase<double>>;
  const Model::Params wire = plant_params(files::load_wire("smartflex-76um").wire);
  Model::State state = Model::rest(wire, {users_ambient_K, users_stress_Pa});
  for (int i = 0; i < 1500; ++i) {
    const double ohm = Model::resistance_ohm(wire, state, users_ambient_K);
    Model::advance(wire, state, {0.17 * 0.17 * ohm, users_stress_Pa, users_ambient_K}, 1e-3);
  }
  std::printf("heated: %.0f degC, strain %.2f %%\n", Model::temperature_K(state) - zero_degC_K,
              100 * Model::strain(wire, state));
}

/// The estimate after 2 s of a recording, beside the strain that the recording has.
void replay(const std::string& trace, const std::string& wire_file) {
  using Observer = Substepping<MultipleModelFilter<double>>;
  const Wire<double> wire = files::load_wire(wire_file).wire;
  const double cold_ohm = cold_resistance_ohm(wire);
  MeasurementParams<double> sensors{};
  sensors.area_m2 = wire.geometry.area_m2();
  sensors.current_noise_A = 1e-5;
  sensors.voltage_noise_V = 3e-4;
  sensors.min_current_A = 0.005;
  sensors.min_resistance_ohm = 0.5 * cold_ohm;
  sensors.max_resistance_ohm = 2 * cold_ohm;
  hal::ReplayBoard board(hal::TraceReader(trace, {}), 0, sensors.area_m2);
  hal::Frame frame{};
  board.read(frame);
  const auto measured = [&] {
    return measure<double>(sensors, {frame.current_A, frame.voltage_V, frame.load_N});
  };
  const Observer::Params model{plant_params(wire), kalman_tuning(wire.accuracy)};
  Observer::State state = Observer::start(model, measured(), users_ambient_K);
  std::int64_t last_ns = frame.time_ns;
  while (last_ns < 2'000'000'000 && board.read(frame) == hal::ReadStatus::frame) {
    Observer::advance(model, state, measured(),
                      1e-9 * static_cast<double>(frame.time_ns - last_ns));
    last_ns = frame.time_ns;
  }
  std::printf("replayed: strain %.1f %%, reference %.1f %%\n",
              100 * Observer::estimate(model, state).strain,
              100 * board.row()[hal::Column::strain_ref]);
}

/// The device holds a strain of 2 % for 2 s.
void hold() {
  using Model = Plant<ThreePhase<float>>;
  const Settings<double> settings = text::parse_settings_file(R"toml(
wire = "smartflex-76um"
measurement.current_full_scale_mA = 500
limits.min_current_mA = 20
limits.current_mA = 400
limits.power_W = 10
limits.temperature_degC = 120
limits.stress_MPa = 300
trips.current_mA = 450
trips.temperature_degC = 130
trips.stress_MPa = 400
)toml",
                                                              "settings");
  const Prepared<float> prepared = prepare(stored_settings<float>(settings));
  Device<float>::State device = Device<float>::start();
  const Model::Params& wire = prepared.observer.model;
  Model::State state = Model::rest(wire, {298.15F, 150e6F});
  const float load_N = 150e6F * prepared.measurement.area_m2;
  float current_A = 0;
  Output<float> out{};
  for (std::uint32_t i = 1; i <= 2000; ++i) {
    const float ohm = Model::resistance_ohm(wire, state, 298.15F);
    Model::advance(wire, state, {current_A * current_A * ohm, 150e6F, 298.15F}, 1e-3F);
    Inputs<float> in{};
    in.fresh = true;
    in.sequence = i;
    in.sample = {current_A, current_A * ohm, load_N};
    in.supply_V = 24;
    in.ambient_K = in.driver_K = NAN;
    Command<float> command{};
    command.fresh = command.arm = true;
    command.mode = Mode::strain;
    command.setpoint = 0.02F;
    out = Device<float>::step(prepared, device, in, command, 1e-3F);
    current_A = out.drive_current_A;
  }
  std::printf(
      "held: %s, strain %.1f %%, faults '%s'\n", std::string(text::state_name(out.state)).c_str(),
      100 * static_cast<double>(Model::strain(wire, state)), text::names_of(out.latched).c_str());
}

template <class F>
void refused(const char* what, F f) {
  try {
    f();
    std::printf("%s: not refused\n", what);
  } catch (const files::Error& error) {
    std::printf("%s: %s\n", what, error.what());
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) {
    return 2;
  }
  heat();
  replay(argv[1], argv[2]);
  hold();
  refused("wire", [] { files::load_wire("flexinol-lt-0.16mm"); });
  refused("spreadsheet", [&] { hal::TraceReader(argv[3], {}); });
}
