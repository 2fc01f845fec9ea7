// An observer of one's own, judged beside ours:
//   host-sim evaluate --observer kalman --observer-program ./06_own_observer
// It takes the strain as linear in the resistance, between those of the hot and of the cold wire
// under the present load. host-sim evaluate writes rows to it, and reads a strain for each.

#include <algorithm>
#include <cstdio>
#include <exception>
#include <iostream>
#include <smaservo/model/files/wire/wire_file.hpp>
#include <smaservo/model/wire/wire_plant.hpp>
#include <sstream>
#include <string>

using namespace smaservo;
namespace {

/// Ends of the line: the wire at rest, cold or hot.
WireOutput<double> at_rest(WirePlant<double>& plant, double load_N, double temperature_K) {
  plant.rest(load_N, temperature_K);
  return plant.output();
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 2) {
    std::fputs("usage: 06_own_observer WIRE.toml < ROWS.csv\n", stderr);
    return 1;
  }
  const Wire<double> wire = files::load_wire(argv[1]).wire;
  WirePlant<double> plant{wire};
  double strain = at_rest(plant, 0, 298.15).strain;
  std::string row;
  std::getline(std::cin, row);  // time_s,current_A,voltage_V,load_N
  while (std::getline(std::cin, row)) {
    double time_s = 0;
    double current_A = 0;
    double voltage_V = 0;
    double load_N = 0;
    char comma = 0;
    std::istringstream numbers(row);
    if (!(numbers >> time_s >> comma >> current_A >> comma >> voltage_V >> comma >> load_N)) {
      std::fprintf(stderr, "not four numbers: %s\n", row.c_str());
      return 1;
    }
    // With less current the resistance is noise: the last strain stays.
    if (current_A > 0.03 * wire.limits.current_A) {
      const WireOutput cold = at_rest(plant, load_N, 298.15);
      const WireOutput hot = at_rest(plant, load_N, wire.limits.temperature_K);
      const double share =
          (voltage_V / current_A - hot.resistance_ohm) / (cold.resistance_ohm - hot.resistance_ohm);
      strain = hot.strain + std::clamp(share, 0.0, 1.0) * (cold.strain - hot.strain);
    }
    std::printf("%.9g\n", strain);
  }
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
