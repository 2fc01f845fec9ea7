// Estimates the strain of a wire from a recorded trace of current, voltage and load:
//   01_estimate_from_csv [TRACE.csv [WIRE.toml]]

#include <fmt/format.h>
#include <string>

#include "hal/replay/board.hpp"
#include "model/files/wire/wire_file.hpp"
#include "observer/measurement.hpp"
#include "observer/multiple_model.hpp"
#include "observer/substepping.hpp"

// The Kalman filter started from several hypotheses at once, for samples at any time intervals.
using Observer = smaservo::Substepping<smaservo::MultipleModelFilter<double>>;

int main(int argc, char** argv) {
  using namespace smaservo;
  const std::string trace = argc > 1 ? argv[1] : "host-sim/traces/150MPa.csv";
  const std::string wire_file = argc > 2 ? argv[2] : "host-sim/traces/units/a.toml";
  const Wire<double> wire = files::load_wire(wire_file).wire;

  // The accuracy of the sensors, and the range of resistances that is possible for this wire.
  const double cold_ohm = cold_resistance_ohm(wire);
  MeasurementParams<double> sensors{};
  sensors.area_m2 = wire.geometry.area_m2();
  sensors.current_noise_A = 1e-5;
  sensors.voltage_noise_V = 3e-4;
  sensors.min_current_A = 0.005;
  sensors.min_resistance_ohm = 0.5 * cold_ohm;
  sensors.max_resistance_ohm = 2 * cold_ohm;

  // The trace is replayed like a board that reads its rows. The first row starts the observer, in
  // air of 25 degC.
  hal::ReplayBoard board(hal::TraceReader(trace, {}), 0, sensors.area_m2);
  hal::Frame frame{};
  board.read(frame);
  const auto measured = [&] {
    return measure<double>(sensors, {frame.current_A, frame.voltage_V, frame.load_N});
  };
  const Observer::Params model{plant_params(wire), kalman_tuning(wire.accuracy)};
  Observer::State state = Observer::start(model, measured(), 298.15);

  fmt::print("time s  strain %    +- %  reference %\n");
  std::int64_t last_ns = frame.time_ns;
  double next_s = 1;
  while (board.read(frame) == hal::ReadStatus::frame) {
    Observer::advance(model, state, measured(),
                      1e-9 * static_cast<double>(frame.time_ns - last_ns));
    last_ns = frame.time_ns;
    if (1e-9 * static_cast<double>(frame.time_ns) >= next_s) {
      const Estimate<double> e = Observer::estimate(model, state);
      fmt::print("{:6.1f}  {:8.2f}  {:6.2f}  {:11.2f}\n", next_s, 100 * e.strain, 100 * e.strain_sd,
                 100 * board.row()[hal::Column::strain_ref]);
      next_s += 1;
    }
  }
}
