#pragma once
// What the sources of the Python module share. Texts that Python programmers read stand beside the
// classes; smaservo/*.pyi has their types.

#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <fmt/format.h>
#include <limits>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "firmware/faults.hpp"
#include "model/files/toml/fields.hpp"

namespace smaservo::python {

namespace py = pybind11;

// One function for each source; bindings.cpp calls them.
void add_errors(py::module_& module);
void add_wire(py::module_& module);
void add_plant(py::module_& module);
void add_estimator(py::module_& module);
void add_settings(py::module_& module);
void add_servo(py::module_& module);
void add_tables(py::module_& module);
void add_identify(py::module_& module);
void add_evaluate(py::module_& module);
void add_inspect(py::module_& module);

/// The overrides that a dict means, as those of --set: numbers in the unit of the key, names of
/// choices, truth values, lists of numbers. Throws TypeError for another value.
std::vector<files::Override> overrides_of(const py::object& settings);

/// "dt_s = -1.0: must be greater than 0" as a ValueError.
[[noreturn]] inline void refuse(std::string_view argument, double value, std::string_view allowed) {
  throw py::value_error(fmt::format("{} = {}: must be {}", argument, value, allowed));
}
inline void require_finite(std::string_view argument, double value) {
  if (!std::isfinite(value)) {
    refuse(argument, value, "a finite number");
  }
}
inline void require_above_0(std::string_view argument, double value, std::string_view allowed) {
  if (!(value > 0 && std::isfinite(value))) {
    refuse(argument, value, allowed);
  }
}

/// The names of the faults in a set.
py::tuple names_of_faults(FaultSet set);

/// Calls Python's handlers of signals, which throw KeyboardInterrupt at Ctrl-C. Needs no GIL.
inline void check_signals() {
  const py::gil_scoped_acquire gil;
  if (PyErr_CheckSignals() != 0) {
    throw py::error_already_set();
  }
}

/// The bytes of an object.
template <class T>
py::bytes bytes_of(const T& object) {
  static_assert(std::is_trivially_copyable_v<T>);
  std::string bytes(sizeof(T), '\0');
  std::memcpy(bytes.data(), &object, sizeof(T));
  return bytes;
}

/// An object's state, which means something to the same version of the package only.
template <class T>
py::tuple packed(const T& object) {
  return py::make_tuple(SMASERVO_VERSION, sizeof(T), bytes_of(object));
}

template <class T>
T unpacked(const py::tuple& state) {
  std::string bytes;
  if (state.size() == 3 && py::isinstance<py::bytes>(state[2]) &&
      py::object(state[0]).equal(py::str(SMASERVO_VERSION)) &&
      py::object(state[1]).equal(py::int_(sizeof(T)))) {
    bytes = state[2].cast<std::string>();
  }
  if (bytes.size() != sizeof(T)) {
    throw py::value_error(
        "the pickled state is of another version of smaservo, or of another machine: pickle the "
        "wire or the settings instead, and let the object run again");
  }
  std::array<std::byte, sizeof(T)> raw;
  std::memcpy(raw.data(), bytes.data(), sizeof(T));
  return std::bit_cast<T>(raw);
}

/// copy.copy(), copy.deepcopy(), copy() and pickle for a class whose objects are their state.
template <class T, class Class>
void add_state(Class& type) {
  type.def(
      "copy", [](const T& self) { return T(self); },
      "A second object in the same state. From here on each goes its own way.");
  type.def("__copy__", [](const T& self) { return T(self); });
  type.def(
      "__deepcopy__", [](const T& self, const py::object&) { return T(self); }, py::arg("memo"));
  type.def(py::pickle([](const T& self) { return packed(self); },
                      [](const py::tuple& state) { return unpacked<T>(state); }));
}

}  // namespace smaservo::python
