// The observer "kalman" as a program for host-sim evaluate --observer-program: what it gets through
// a file and a pipe is all that the built-in one gets.

#include <exception>
#include <fmt/format.h>
#include <iostream>
#include <memory>
#include <sstream>
#include <string>

#include "host-sim/replay/measurement_params.hpp"
#include "host-sim/replay/observers.hpp"
#include "model/files/message.hpp"
#include "model/files/wire/wire_file.hpp"
#include "model/units.hpp"

namespace smaservo::test {
namespace {

void observe(const std::string& wire_file) {
  const Wire<double> wire = files::load_wire(wire_file).wire;
  const MeasurementParams<double> measurement = replay::measurement_params(wire, {});
  std::unique_ptr<replay::AnyObserver> observer;
  std::string line;
  std::getline(std::cin, line);
  double last_s = 0;
  while (std::getline(std::cin, line)) {
    std::istringstream fields(line);
    double time_s = 0;
    Sample<double> sample{};
    char comma = 0;
    fields >> time_s >> comma >> sample.current_A >> comma >> sample.voltage_V >> comma >>
        sample.load_N;
    const Measurement<double> m = measure(measurement, sample);
    if (observer) {
      observer->advance(m, time_s - last_s);
    } else {
      observer = replay::make_observer("kalman", wire, {}, m, room_K);
    }
    last_s = time_s;
    const Estimate<double> e = observer->estimate();
    files::print(fmt::format("{},{}\n", e.strain, e.strain_sd));
  }
}

}  // namespace
}  // namespace smaservo::test

int main(int argc, char** argv) {
  try {
    if (argc == 2) {
      smaservo::test::observe(argv[1]);
      return 0;
    }
  } catch (const std::exception& error) {
    smaservo::files::complain("own_observer", error.what());
  }
  return 1;
}
