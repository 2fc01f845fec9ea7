// Estimates the strain of a wire from a recorded trace of current, voltage and load:
//   01_estimate_from_csv [TRACE.csv [WIRE.toml]]

#include <cstdio>
#include <exception>
#include <smaservo/hal/replay/board.hpp>
#include <smaservo/model/files/wire/wire_file.hpp>
#include <smaservo/observer/estimator.hpp>
#include <string>

using namespace smaservo;

int main(int argc, char** argv) try {
  const std::string trace = argc > 1 ? argv[1] : "host-sim/traces/150MPa.csv";
  const std::string wire_file = argc > 2 ? argv[2] : "host-sim/traces/units/a.toml";

  // What you need: a wire and an estimator for it.
  const Wire<double> wire = files::load_wire(wire_file).wire;
  Estimator estimator{wire};

  // The trace is read like a board: any columns and units that `host-sim replay` knows. The load of
  // a trace without one would be the 0 N here.
  hal::ReplayBoard board(hal::TraceReader(trace, {}), 0, wire.geometry.area_m2());
  hal::Frame frame{};
  std::puts("time s  strain %    +- %  reference %");
  std::int64_t last_ns = 0;
  double next_s = 1;
  while (board.read(frame) == hal::ReadStatus::frame) {
    const double dt_s = 1e-9 * static_cast<double>(frame.time_ns - last_ns);
    last_ns = frame.time_ns;

    // One reading in, one estimate out.
    const Estimate now = estimator.update(
        {.current_A = frame.current_A, .voltage_V = frame.voltage_V, .load_N = frame.load_N}, dt_s);

    if (1e-9 * static_cast<double>(frame.time_ns) >= next_s) {
      std::printf("%6.1f  %8.2f  %6.2f  %11.2f\n", next_s, 100 * now.strain, 100 * now.strain_sd,
                  100 * board.row()[hal::Column::strain_ref]);
      next_s += 1;
    }
  }
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
