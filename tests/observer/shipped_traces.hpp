#pragma once
// The project's own traces, with the wires that they were recorded of.

#include <string>
#include <vector>

#include "hal/replay/trace.hpp"
#include "model/files/wire/wire_file.hpp"
#include "observer/measurement.hpp"
#include "tests/places.hpp"

namespace smaservo {

struct ShippedTrace {
  std::string name, unit;
};

inline const std::vector<ShippedTrace>& shipped_traces() {
  static const std::vector<ShippedTrace> traces{
      {"150MPa", "a"}, {"100MPa", "b"},  {"200MPa", "b"},    {"400MPa", "a"},
      {"spring", "a"}, {"varying", "b"}, {"disturbed", "a"}, {"unknown-start", "b"},
      {"50MPa", "a"},  {"25MPa", "b"},   {"10MPa", "a"}};
  return traces;
}

/// A trace's rows: what was measured at the end of an interval of dt_s.
struct TraceStep {
  Sample<double> sample;
  double dt_s;
};

inline std::vector<TraceStep> load_trace(const std::string& path) {
  hal::TraceReader reader(path, {});
  std::vector<TraceStep> steps;
  hal::TraceRow row{};
  double last_s = 0;
  while (reader.next(row)) {
    const double now_s = row[hal::Column::time];
    steps.push_back({{row[hal::Column::current], row[hal::Column::voltage], row[hal::Column::load]},
                     steps.empty() ? 0 : now_s - last_s});
    last_s = now_s;
  }
  return steps;
}

inline std::vector<TraceStep> load_trace(const ShippedTrace& trace) {
  return load_trace(test::source_folder() + "/host-sim/traces/" + trace.name + ".csv");
}

inline Wire<double> load_unit(const ShippedTrace& trace) {
  return files::load_wire(test::source_folder() + "/host-sim/traces/units/" + trace.unit + ".toml")
      .wire;
}

/// A good front end for this wire.
inline MeasurementParams<double> measurement_params(const Wire<double>& wire) {
  const double ohm = cold_resistance_ohm(wire);
  return {wire.geometry.area_m2(), 0, 0, 1e-5, 3e-4, 0, 1e-3, 0.5 * ohm, 2 * ohm};
}

}  // namespace smaservo
