// smaservo.Wire

#include "host-sim/python/bindings/wire.hpp"

#include <cstdint>

#include "model/files/message.hpp"
#include "model/files/similar.hpp"
#include "model/wire/wire_parameters.hpp"

namespace smaservo::python {
namespace {

using files::WireDescription;
using WireRow = WireParameter<double>;

py::object wire_number(const WireRow& row, const Wire<double>& wire) {
  const double value = row.get(wire);
  switch (row.type) {
    case ValueType::choice:
      return py::str(std::string(row.choices[static_cast<std::size_t>(value)]));
    case ValueType::boolean:
      return py::bool_(value != 0);
    case ValueType::number:
      return py::int_(static_cast<std::uint32_t>(value));
    case ValueType::real:
      break;
  }
  return py::float_(value);
}

py::object wire_item(const WireDescription& self, const std::string& path) {
  std::vector<std::string> names;
  for (const WireRow& row : wire_parameters<double>) {
    if (row.path.text() == path && row.is_used(self.wire)) {
      return wire_number(row, self.wire);
    }
    names.emplace_back(row.path.text());
    if (row.path.text() == path) {
      throw py::key_error(
          fmt::format("{} is not used: this wire has no surface of its own for it", path));
    }
  }
  throw py::key_error(fmt::format("{} is no parameter of a wire{}", files::printable(path),
                                  files::did_you_mean(path, names)));
}

py::dict wire_numbers(const WireDescription& self) {
  py::dict all;
  for (const WireRow& row : wire_parameters<double>) {
    if (row.is_used(self.wire)) {
      all[py::str(std::string(row.path.text()))] = wire_number(row, self.wire);
    }
  }
  return all;
}

/// All numbers that the wire uses, to the bit.
std::string bits_of(const Wire<double>& wire) {
  std::string bits;
  for (const WireRow& row : wire_parameters<double>) {
    const double value = row.get(wire);
    bits += row.is_used(wire) ? '1' : '0';
    if (row.is_used(wire)) {
      bits += std::to_string(std::bit_cast<std::uint64_t>(value)) + ',';
    }
  }
  return bits;
}

WireDescription parse_wire_text(const std::string& text, const py::object& settings,
                                const std::string& folder) {
  return files::parse_wire(text, "text", overrides_of(settings), folder);
}

WireDescription replaced(const WireDescription& self, const py::object& settings) {
  return files::parse_wire(files::to_toml(self), self.name, overrides_of(settings));
}

constexpr const char* wire_doc =
    R"(A wire: its geometry, the maker's limits and the parameters of its model.

It never changes; replace() makes another one. Two wires are equal if all their numbers are, to the
bit; name and sources do not count. Wires can be keys of dicts, and are pickled to the same bits.

>>> import smaservo
>>> wire = smaservo.Wire.load("smartflex-76um", {"wire.length_mm": 120})
>>> wire
<smaservo.Wire smartflex-76um: 120 mm, 76 um>
>>> wire["wire.length_m"], wire.length_m
(0.12, 0.12)
)";

}  // namespace

void add_wire(py::module_& module) {
  py::class_<WireDescription> type(module, "Wire", wire_doc);
  type.attr("__module__") = "smaservo";
  const auto quantity = [&](const char* name, auto of, const char* doc) {
    type.def_property_readonly(
        name, [of](const WireDescription& self) { return double{of(self.wire)}; }, doc);
  };
  type.def_static(
      "load",
      [](const py::object& name, const py::object& settings) {
        const auto path = py::module_::import("os").attr("fspath")(name).cast<std::string>();
        return files::load_wire(path, overrides_of(settings));
      },
      py::arg("name_or_path"), py::arg("settings") = py::none(),
      R"(A preset (see wire_presets()) or a wire file, whose name ends in .toml.

settings replaces keys, as `--set` of host-sim does: any unit of the key's kind may be its end.
Raises ConfigError, which names file, line, key, value and what is allowed.

>>> import smaservo
>>> smaservo.Wire.load("flexinol-lt-0.15mm", {"wire.length_mm": 200}).length_m
0.2
)");
  type.def_static("parse", &parse_wire_text, py::arg("text"), py::arg("settings") = py::none(),
                  py::arg("folder") = ".",
                  R"(The same from the text of a wire file; a file that it is based on is in folder.

>>> import smaservo
>>> smaservo.Wire.parse('based_on = "smartflex-76um"\n[wire]\nlength_mm = 80').length_m
0.08
)");
  type.def("replace", &replaced, py::arg("settings"),
           R"(A wire with other values for some keys. Nothing else follows from them.

>>> import smaservo
>>> wire = smaservo.Wire.load("smartflex-76um")
>>> wire.replace({"wire.length_mm": 50}).length_m
0.05
)");
  type.def("to_toml", &files::to_toml,
           "The text of a wire file that is read back to the same numbers.");
  type.def("parameters", &wire_numbers,
           R"(All parameters that the wire uses, by path, in SI.

>>> import smaservo
>>> smaservo.Wire.load("smartflex-76um").parameters()["wire.material.mixture"]
'series'
)");
  type.def("__getitem__", &wire_item, py::arg("path"), "A parameter by its path, in SI.");
  type.def_property_readonly(
      "name", [](const WireDescription& self) { return files::printable(self.name); },
      "The wire's name: the preset's, or that in the file.");
  type.def_property_readonly(
      "sources",
      [](const WireDescription& self) {
        py::dict all;
        for (const auto& [key, source] : self.sources) {
          all[py::str(files::printable(key))] = files::printable(source);
        }
        return all;
      },
      "Where the numbers come from, by key or group of keys.");
  using W = Wire<double>;
  quantity("length_m", [](const W& w) { return w.geometry.length_m; }, "Length at no strain.");
  quantity("diameter_m", [](const W& w) { return w.geometry.diameter_m; }, "Diameter.");
  quantity("area_m2", [](const W& w) { return w.geometry.area_m2(); }, "Cross-section.");
  quantity(
      "cold_resistance_ohm", [](const W& w) { return cold_resistance_ohm(w); },
      "Resistance of the whole wire at rest at 25 degC.");
  quantity(
      "nominal_stroke", [](const W& w) { return w.nominal_stroke; },
      "The strain that errors are related to.");
  quantity(
      "max_current_A", [](const W& w) { return w.limits.current_A; },
      "The maker's greatest current in still air.");
  quantity(
      "max_stress_Pa", [](const W& w) { return w.limits.stress_Pa; },
      "The maker's greatest stress.");
  quantity(
      "max_temperature_K", [](const W& w) { return w.limits.temperature_K; },
      "The greatest temperature of the wire.");
  type.def(
      "__eq__",
      [](const WireDescription& self, const py::object& other) -> py::object {
        if (!py::isinstance<WireDescription>(other)) {
          return py::reinterpret_borrow<py::object>(Py_NotImplemented);
        }
        return py::bool_(bits_of(self.wire) == bits_of(other.cast<const WireDescription&>().wire));
      },
      py::arg("other"));
  type.def("__hash__",
           [](const WireDescription& self) { return py::hash(py::bytes(bits_of(self.wire))); });
  type.def("__repr__", [](const WireDescription& self) {
    return fmt::format("<smaservo.Wire {}: {:.6g} mm, {:.6g} um>", files::printable(self.name),
                       1e3 * self.wire.geometry.length_m, 1e6 * self.wire.geometry.diameter_m);
  });
  // The text is read back to the same bits.
  type.def(py::pickle(&files::to_toml, [](const std::string& text) {
    return files::parse_wire(text, "pickled wire");
  }));
  module.def("wire_presets", &files::preset_names,
             R"(The names of the wires that are built in.

>>> import smaservo
>>> "smartflex-76um" in smaservo.wire_presets()
True
)");
}

}  // namespace smaservo::python
