// smaservo.Servo

#include "firmware/device/servo.hpp"

#include "firmware/text/device_names.hpp"
#include "host-sim/python/bindings/settings.hpp"
#include "model/files/message.hpp"

namespace smaservo::python {
namespace {

using SteppedServo = Servo<double>;
using ServoOutput = Output<double>;

Mode mode_of(const std::string& name) {
  if (const auto mode = text::mode_of(name)) {
    return *mode;
  }
  std::string all;
  for (std::uint8_t i = 0; i < mode_count; ++i) {
    all += (i == 0 ? "" : ", ") + std::string(text::mode_name(static_cast<Mode>(i)));
  }
  throw py::value_error(fmt::format("mode = '{}': must be one of {}", files::printable(name), all));
}

ServoOutput update_servo(SteppedServo& self, double current_A, double voltage_V, double load_N,
                         const std::string& mode, double setpoint, double dt_s, bool clear_faults) {
  Command<double> command{};
  command.mode = mode_of(mode);
  command.setpoint = setpoint;
  command.clear_faults = clear_faults;
  require_finite("setpoint", setpoint);
  require_above_0("dt_s", dt_s, "greater than 0 and finite");
  return self.update({current_A, voltage_V, load_N}, command, dt_s);
}

py::tuple limit_reasons_of(const ServoOutput& out) {
  py::list names;
  for (std::size_t i = 0; i < static_cast<std::size_t>(LimitReason::count); ++i) {
    const auto reason = static_cast<LimitReason>(i);
    if (out.limited_by(reason)) {
      names.append(py::str(std::string(text::limit_reason_name(reason))));
    }
  }
  return {names};
}

constexpr const char* servo_doc =
    R"(The whole device: it measures, observes, protects and controls, as smaservod does.

It takes Settings, and checks them. A copy (copy.copy(), pickle) is a saved state. Here a simulated
wire is held at a strain of 3 %, with more current than its maker allows in still air:

>>> import smaservo
>>> settings = smaservo.Settings.for_wire(smaservo.Wire.load("smartflex-76um")).replace(
...     {"limits.current_mA": 200, "limits.power_W": 2, "trips.current_mA": 250})
>>> servo, plant = smaservo.Servo(settings), smaservo.Plant(settings.wire, load_N=0.5)
>>> current_A = 0.0
>>> for _ in range(4000):
...     voltage_V = current_A * plant.output().resistance_ohm
...     out = servo.update(current_A, voltage_V, 0.5, mode="strain", setpoint=0.03, dt_s=1e-3)
...     current_A = out.drive_current_A
...     wire = plant.update(current_A, load_N=0.5, dt_s=1e-3)
>>> out.state, out.latched, abs(wire.strain - 0.03) < 0.001
('running', (), True)

What drives a real current must end it by itself when this loop hangs or raises.
)";

constexpr const char* output_doc = R"(What a step of a Servo gives.

drive_current_A (and drive_voltage_V for a drive of voltage) is what to give to the wire, zero unless
heat is allowed. state, mode, setpoint (after limits) and reference (of the trajectory) are in force;
wanted_power_W is what the controller asks for, after limits. estimate is the observer's, resistance_ohm
the measured resistance or NaN, estimated_ambient_K the air by the observer, hot_spot_K the highest
temperature to be expected anywhere along the wire, cooling its cooling as a share of the wire file's.

latched are the faults that have not been cleared, first_cause the first of them or None; active are
the conditions that are present now, warnings those that do not end heat, blocks what is in the way of
arming, limit_reasons what holds the output back: tuples of names, which `host-sim explain` explains.
time_s is the time of the loop.
)";

}  // namespace

void add_servo(py::module_& module) {
  py::class_<ServoOutput> out(module, "ServoOutput", output_doc);
  out.attr("__module__") = "smaservo";
  out.def_readonly("drive_current_A", &ServoOutput::drive_current_A);
  out.def_readonly("drive_voltage_V", &ServoOutput::drive_voltage_V);
  out.def_property_readonly(
      "state", [](const ServoOutput& o) { return std::string(text::state_name(o.state)); });
  out.def_property_readonly(
      "mode", [](const ServoOutput& o) { return std::string(text::mode_name(o.mode)); });
  out.def_readonly("setpoint", &ServoOutput::setpoint);
  out.def_readonly("reference", &ServoOutput::reference);
  out.def_readonly("wanted_power_W", &ServoOutput::wanted_power_W);
  out.def_property_readonly("estimate", [](const ServoOutput& o) { return o.estimate; });
  out.def_property_readonly("resistance_ohm", [](const ServoOutput& o) {
    return o.measurement.resistance_valid ? o.measurement.resistance_ohm
                                          : std::numeric_limits<double>::quiet_NaN();
  });
  out.def_readonly("estimated_ambient_K", &ServoOutput::estimated_ambient_K);
  out.def_readonly("hot_spot_K", &ServoOutput::hot_spot_K);
  out.def_readonly("cooling", &ServoOutput::cooling);
  out.def_property_readonly("limit_reasons", &limit_reasons_of);
  out.def_property_readonly("active",
                            [](const ServoOutput& o) { return names_of_faults(o.active); });
  out.def_property_readonly("latched",
                            [](const ServoOutput& o) { return names_of_faults(o.latched); });
  out.def_property_readonly("warnings",
                            [](const ServoOutput& o) { return names_of_faults(o.warnings); });
  out.def_property_readonly("blocks",
                            [](const ServoOutput& o) { return names_of_faults(o.blocks); });
  out.def_property_readonly("first_cause", [](const ServoOutput& o) -> py::object {
    if (o.first_cause == Fault::none) {
      return py::none();
    }
    return py::str(text::names_of(o.first_cause));
  });
  out.def_property_readonly(
      "time_s", [](const ServoOutput& o) { return 1e-6 * static_cast<double>(o.time_us); });
  out.def("__repr__", [](const ServoOutput& o) {
    return fmt::format(
        "<smaservo.ServoOutput drive_current_A={:.5g} state={} mode={} setpoint={:.5g} latched={}>",
        o.drive_current_A, text::state_name(o.state), text::mode_name(o.mode), o.setpoint,
        o.latched.empty() ? "none" : text::names_of(o.latched));
  });
  out.def(py::pickle(&packed<ServoOutput>, &unpacked<ServoOutput>));

  py::class_<SteppedServo> type(module, "Servo", servo_doc);
  type.attr("__module__") = "smaservo";
  type.def(py::init([](const DeviceSettings& settings) {
             check_settings(settings);
             return SteppedServo(settings.settings);
           }),
           py::arg("settings"));
  type.def("update", &update_servo, py::arg("current_A"), py::arg("voltage_V"), py::arg("load_N"),
           py::arg("mode"), py::arg("setpoint"), py::arg("dt_s"), py::arg("clear_faults") = false,
           R"(One period: readings and a set-point in, what to drive out.

dt_s is the time since the last one, 0.1 to 20 ms; after a longer one the device reports loop_stalled
and gives no current. A reading that is NaN is a sensor that has failed, and ends heat. mode is
"off", "current" (A), "power" (W), "resistance" (ohm), "temperature" (K), "strain", "position" (m),
"force" (N) or "identification"; the set-point is in the mode's SI unit, and is limited to what is
allowed. Any mode but "off" asks to run: the device then arms itself, which takes some tenths of a
second, unless ServoOutput.blocks says what is in the way. A latched fault stays until clear_faults.
Raises ValueError for another mode, and for a set-point or dt_s that is no number; then nothing has
been computed, and no current may be given.
)");
  type.def_property_readonly(
      "last", [](const SteppedServo& self) { return self.last(); },
      "The output of the last step; all zero before the first.");
  type.def_property_readonly(
      "settings", [](const SteppedServo& self) { return DeviceSettings{self.settings()}; },
      "A copy of the settings.");
  add_state<SteppedServo>(type);
}

}  // namespace smaservo::python
