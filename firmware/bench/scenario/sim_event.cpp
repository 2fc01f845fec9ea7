#include "firmware/bench/scenario/sim_event.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "firmware/bench/scenario/scenario_tables.hpp"
#include "model/units.hpp"

namespace smaservo::bench {
namespace {

constexpr double for_ever = std::numeric_limits<double>::infinity();
constexpr double rounding_s = 1e-9;

constexpr std::array<std::string_view, 3> wire_states{"broken", "open", "shorted"};
constexpr std::array<std::string_view, hal::reading_count> readings{"current", "voltage", "load",
                                                                    "supply",  "ambient", "driver"};
constexpr std::array<std::string_view, 6> sensor_faults{"missing", "stuck", "offset",
                                                        "noise",   "value", "gain"};
/// The greatest amount of a sensor's fault, by hal::Reading: A, V, N, V, K, K.
constexpr std::array<double, hal::reading_count> max_amounts{1e3, 1e4, 1e4, 1e4, 1e3, 1e3};

void read_surroundings(files::TomlTable& table, SimEvent& event) {
  if (table.has("ambient_degC")) {
    event.ambient_K = zero_degC_K + table.number("ambient_degC", -60, 150);
  }
  if (table.has("draught")) {
    event.draught = table.number("draught", 0.1, 20);
  }
  if (table.has("supply_V")) {
    event.supply_V = table.number("supply_V", 0, 1000);
  }
  if (table.has("load_MPa")) {
    event.added_stress_Pa = 1e6 * table.number("load_MPa", -1000, 1000);
  }
  if (table.has("slip_percent")) {
    event.slip = 0.01 * table.number("slip_percent", 0, 10);
  }
  if (table.has("driver_above_K")) {
    event.driver_above_K = table.number("driver_above_K", 0, 200);
  }
  if (table.has("stop_percent")) {
    event.stop_strain = 0.01 * table.number("stop_percent", 0.01, 10);
  }
}

void read_breakage(files::TomlTable& table, SimEvent& event) {
  if (table.has("wire")) {
    event.circuit = static_cast<hal::Circuit>(1 + table.choice("wire", wire_states));
    if (*event.circuit == hal::Circuit::shorted) {
      event.bridged_share = table.number("bridged_share", 0.01, 0.99);
    }
  }
  if (table.has("sensor")) {
    const std::size_t reading = table.choice("sensor", readings);
    hal::SpoiltSensor spoilt{
        static_cast<hal::SensorFault>(1 + table.choice("fault", sensor_faults)), 0};
    if (spoilt.fault >= hal::SensorFault::offset) {
      const double max = max_amounts.at(reading);
      spoilt.amount = table.number("amount", -max, max);
    }
    event.sensor = {static_cast<hal::Reading>(reading), spoilt};
  }
}

}  // namespace

std::vector<SimEvent> read_events(std::vector<files::TomlTable> tables) {
  std::vector<SimEvent> events;
  for (files::TomlTable& table : tables) {
    SimEvent event{};
    event.at_s = table.number("at_s", 0, longest_s);
    event.for_s = table.number("for_s", 0.001, longest_s, for_ever);
    read_surroundings(table, event);
    read_breakage(table, event);
    event.lost_share = table.number("lost_frames", 0, 1, 0);
    event.emergency_stop = table.flag("emergency_stop", false);
    event.driver_fault = table.flag("driver_fault", false);
    event.late = table.flag("late", false);
    table.finish();
    events.push_back(event);
  }
  return events;
}

bool SimEvent::holds(double time_s) const {
  return at_s - rounding_s <= time_s && time_s < at_s + for_s - rounding_s;
}

SimEvents::SimEvents(std::vector<SimEvent> events, const hal::SimSurroundings& without)
    : events_(std::move(events)),
      without_(without),
      next_s_(events_.empty() ? for_ever : -for_ever) {}

void SimEvents::change(double time_s, hal::SimBoard& board) {
  hal::SimSurroundings around = without_;
  hal::FrontEndFaults faults{};
  late_ = false;
  reboots_ = false;
  next_s_ = for_ever;
  for (const SimEvent& event : events_) {
    const double end_s = event.at_s + event.for_s;
    for (const double edge_s : {event.at_s - rounding_s, end_s - rounding_s}) {
      next_s_ = edge_s > time_s ? std::min(next_s_, edge_s) : next_s_;
    }
    if (!event.holds(time_s)) {
      continue;
    }
    around.ambient_K = event.ambient_K.value_or(around.ambient_K);
    around.draught = event.draught.value_or(around.draught);
    around.supply_V = event.supply_V.value_or(around.supply_V);
    around.added_stress_Pa += event.added_stress_Pa.value_or(0);
    around.slip += event.slip.value_or(0);
    around.driver_above_K = event.driver_above_K.value_or(around.driver_above_K);
    around.stop_strain = event.stop_strain.value_or(around.stop_strain);
    if (const auto& circuit = event.circuit) {
      faults.circuit = *circuit;
      faults.bridged_share = event.bridged_share;
    }
    if (const auto& sensor = event.sensor) {
      faults.sensors[static_cast<std::size_t>(sensor->first)] = sensor->second;
    }
    faults.lost_share = std::max(faults.lost_share, event.lost_share);
    faults.emergency_stop = faults.emergency_stop || event.emergency_stop;
    faults.driver_fault = faults.driver_fault || event.driver_fault;
    late_ = late_ || event.late;
    reboots_ = reboots_ || event.reboots;
  }
  board.surroundings = around;
  board.faults() = faults;
}

}  // namespace smaservo::bench
