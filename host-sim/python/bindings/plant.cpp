// smaservo.Plant

#include "host-sim/python/bindings/wire.hpp"
#include "model/wire/wire_plant.hpp"

namespace smaservo::python {
namespace {

using SimulatedPlant = WirePlant<double>;
using PlantInput = WireInput<double>;
using PlantOutput = WireOutput<double>;

void check_input(const PlantInput& in, double dt_s) {
  require_finite("current_A", in.current_A);
  require_finite("load_N", in.load_N);
  require_above_0("ambient_K", in.ambient_K, "greater than 0 and finite");
  require_above_0("draught", in.draught, "greater than 0 and finite");
  if (!(0 < dt_s && dt_s <= SimulatedPlant::longest_update_s)) {
    refuse("dt_s", dt_s, "greater than 0 and at most 60");
  }
}

PlantOutput require_made(const PlantOutput& out) {
  if (std::isnan(out.strain)) {
    throw py::value_error(
        "current_A and load_N: the wire's state would not be finite; the wire stays as it was");
  }
  return out;
}

constexpr const char* plant_doc =
    R"(A simulated wire: current and load in, strain, resistance and temperature out.

It has the three-phase model and one temperature. At first it rests under load_N at ambient_K,
cooled from far above. A copy (copy.copy(), pickle) is a saved state.

>>> import smaservo
>>> plant = smaservo.Plant(smaservo.Wire.load("smartflex-76um"), load_N=0.68)
>>> cold = plant.output().strain
>>> for _ in range(1000):
...     now = plant.update(current_A=0.2, load_N=0.68, dt_s=1e-3)
>>> now.strain < cold
True
)";

constexpr const char* state_doc = R"(A wire after a step.

strain is the elongation of the whole wire, resistance_ohm that of the wire alone, temperature_K that
of its middle; martensite and r_phase are mean fractions over the whole wire, austenite is the rest.
)";

py::tuple numbers_of(const PlantOutput& s) {
  return py::make_tuple(s.strain, s.resistance_ohm, s.temperature_K, s.martensite, s.r_phase);
}

}  // namespace

void add_plant(py::module_& module) {
  py::class_<PlantOutput> state(module, "PlantState", state_doc);
  state.attr("__module__") = "smaservo";
  state.def_readonly("strain", &PlantOutput::strain);
  state.def_readonly("resistance_ohm", &PlantOutput::resistance_ohm);
  state.def_readonly("temperature_K", &PlantOutput::temperature_K);
  state.def_readonly("martensite", &PlantOutput::martensite);
  state.def_readonly("r_phase", &PlantOutput::r_phase);
  state.def("__repr__", [](const PlantOutput& s) {
    return fmt::format(
        "<smaservo.PlantState strain={:.5g} resistance_ohm={:.5g} temperature_K={:.5g} "
        "martensite={:.3g} r_phase={:.3g}>",
        s.strain, s.resistance_ohm, s.temperature_K, s.martensite, s.r_phase);
  });
  state.def(py::pickle(&numbers_of, [](const py::tuple& t) {
    const auto at = [&](std::size_t i) { return t[i].cast<double>(); };
    return PlantOutput{at(0), at(1), at(2), at(3), at(4)};
  }));

  py::class_<SimulatedPlant> type(module, "Plant", plant_doc);
  type.attr("__module__") = "smaservo";
  type.def(py::init([](const files::WireDescription& wire, double load_N, double ambient_K) {
             require_finite("load_N", load_N);
             require_above_0("ambient_K", ambient_K, "greater than 0 and finite");
             return SimulatedPlant(wire.wire, load_N, ambient_K);
           }),
           py::arg("wire"), py::arg("load_N") = 0.0, py::arg("ambient_K") = room_K);
  type.def(
      "update",
      [](SimulatedPlant& self, double current_A, double load_N, double dt_s, double ambient_K,
         double draught) {
        const PlantInput in{current_A, load_N, ambient_K, draught};
        check_input(in, dt_s);
        return require_made(self.update(in, dt_s));
      },
      py::arg("current_A"), py::arg("load_N"), py::arg("dt_s"), py::arg("ambient_K") = room_K,
      py::arg("draught") = 1.0,
      R"(Lets current and load act for dt_s, which is at most 60, and returns the wire after it.

draught is a factor on the heat loss of still air. A longer step than 5 ms is divided. Raises
ValueError for an argument out of its range; the wire then stays as it was.
)");
  type.def(
      "after",
      [](const SimulatedPlant& self, double current_A, double load_N, double dt_s, double ambient_K,
         double draught) {
        const PlantInput in{current_A, load_N, ambient_K, draught};
        check_input(in, dt_s);
        return require_made(self.after(in, dt_s));
      },
      py::arg("current_A"), py::arg("load_N"), py::arg("dt_s"), py::arg("ambient_K") = room_K,
      py::arg("draught") = 1.0,
      R"(What update() would return; the wire does not change.

The load of a step that depends on the strain, as a spring's does, is sought with it.
)");
  type.def(
      "rest",
      [](SimulatedPlant& self, double load_N, double ambient_K) {
        require_finite("load_N", load_N);
        require_above_0("ambient_K", ambient_K, "greater than 0 and finite");
        self.rest(load_N, ambient_K);
      },
      py::arg("load_N") = 0.0, py::arg("ambient_K") = room_K,
      "Puts the wire at rest, as a new one is.");
  type.def("output", &SimulatedPlant::output, "The wire as it is now.");
  add_state<SimulatedPlant>(type);
}

}  // namespace smaservo::python
