// smaservo.Settings

#include "host-sim/python/bindings/settings.hpp"

#include <optional>

#include "firmware/parameters/parameter_check.hpp"
#include "firmware/text/settings_file.hpp"
#include "firmware/text/settings_text.hpp"
#include "model/files/error.hpp"
#include "model/files/message.hpp"
#include "model/files/similar.hpp"

namespace smaservo::python {
namespace {

using SettingRow = Parameter<double>;

const SettingRow& row_of(const std::string& path) {
  const std::size_t i = find_parameter(path);
  if (i == no_parameter) {
    std::vector<std::string> names;
    names.reserve(parameter_count);
    for (const SettingRow& row : parameters<double>) {
      names.emplace_back(row.path.text());
    }
    throw py::key_error(fmt::format("{} is no setting{}", files::printable(path),
                                    files::did_you_mean(path, names)));
  }
  return parameters<double>[i];
}

py::object value_of(const SettingRow& row, const Settings<double>& settings) {
  const Value value = row.get(settings);
  switch (row.type) {
    case ValueType::choice:
      return py::str(std::string(row.choices[value.number()]));
    case ValueType::boolean:
      return py::bool_(value.number() != 0);
    case ValueType::number:
      return py::int_(value.number());
    case ValueType::real:
      break;
  }
  return py::float_(static_cast<double>(value.real()));
}

/// The value of a row that this object is; nullopt: it is none.
std::optional<Value> value_in(const SettingRow& row, const py::object& object) {
  const bool is_bool = py::isinstance<py::bool_>(object);
  switch (row.type) {
    case ValueType::choice:
      for (std::size_t i = 0; i < row.choices.size(); ++i) {
        if (py::isinstance<py::str>(object) && object.cast<std::string>() == row.choices[i]) {
          return Value::number(static_cast<std::uint32_t>(i));
        }
      }
      return std::nullopt;
    case ValueType::boolean:
      return is_bool ? std::optional(Value::number(object.cast<bool>() ? 1 : 0)) : std::nullopt;
    case ValueType::number: {
      if (is_bool || PyIndex_Check(object.ptr()) == 0) {
        return std::nullopt;
      }
      const py::int_ whole(object);
      return whole >= py::int_(0) && whole <= py::int_(0xFFFFFFFFU)
                 ? std::optional(Value::number(whole.cast<std::uint32_t>()))
                 : std::nullopt;
    }
    case ValueType::real:
      break;
  }
  if (is_bool || PyNumber_Check(object.ptr()) == 0 || PyComplex_Check(object.ptr()) != 0) {
    return std::nullopt;
  }
  return Value::real(static_cast<float>(py::float_(object).cast<double>()));
}

void set_item(DeviceSettings& self, const std::string& path, const py::object& object) {
  const SettingRow& row = row_of(path);
  const std::optional<Value> value = value_in(row, object);
  if (!value || fit(row, *value) != Fit::inside) {
    throw files::ConfigError(fmt::format("{} = {}: must be {}", path,
                                         files::printable(py::str(object).cast<std::string>()),
                                         text::range_text(row)));
  }
  if (!row.is_used(self.settings)) {
    throw py::key_error(
        fmt::format("{} is not used: this wire has no surface of its own for it", path));
  }
  row.set(self.settings, *value);
}

py::object get_item(const DeviceSettings& self, const std::string& path) {
  const SettingRow& row = row_of(path);
  if (!row.is_used(self.settings)) {
    throw py::key_error(
        fmt::format("{} is not used: this wire has no surface of its own for it", path));
  }
  return value_of(row, self.settings);
}

py::dict all_settings(const DeviceSettings& self) {
  py::dict all;
  for (const SettingRow& row : parameters<double>) {
    if (row.is_used(self.settings)) {
      all[py::str(std::string(row.path.text()))] = value_of(row, self.settings);
    }
  }
  return all;
}

DeviceSettings parse_settings_text(const std::string& text, const py::object& settings,
                                   const std::string& folder) {
  return {text::parse_settings_file(text, "text", overrides_of(settings), folder)};
}

constexpr const char* settings_doc = R"(The settings of a device: limits, trips, gains, its wire.

settings["limits.current_A"] reads and sets one by its path, in SI; a value out of its range raises
ConfigError. Values are rounded to 32 bits, as a device has them. Whether they go together is judged
by check(), and by Servo.

>>> import smaservo
>>> settings = smaservo.Settings.for_wire(smaservo.Wire.load("smartflex-76um"))
>>> settings["limits.current_A"] = 0.125
>>> settings["limits.current_A"]
0.125
)";

}  // namespace

void check_settings(const DeviceSettings& settings) {
  text::parse_settings_file(text::to_toml(settings.settings), "settings");
}

void add_settings(py::module_& module) {
  using T = DeviceSettings;
  py::class_<T> type(module, "Settings", settings_doc);
  type.attr("__module__") = "smaservo";
  type.def_static(
      "load",
      [](const py::object& name, const py::object& settings) {
        const auto path = py::module_::import("os").attr("fspath")(name).cast<std::string>();
        return T{text::load_settings_file(path, overrides_of(settings))};
      },
      py::arg("path"), py::arg("settings") = py::none(),
      R"(A settings file, as smaservod has it; settings replaces keys, in any unit of their kind.

Raises ConfigError, which names file, line, key, value and what is allowed.
)");
  type.def_static("parse", &parse_settings_text, py::arg("text"), py::arg("settings") = py::none(),
                  py::arg("folder") = ".",
                  R"(The same from the text of a settings file; a wire file is looked for in folder.

>>> import smaservo
>>> smaservo.Settings.parse('wire = "smartflex-76um"')["limits.min_current_A"]
0.009999999776482582
)");
  type.def_static(
      "for_wire",
      [](const files::WireDescription& wire) {
        const T made{text::settings_for(wire.wire)};
        check_settings(made);
        return made;
      },
      py::arg("wire"), "The default settings, with the limits that the wire's maker states.");
  type.def(
      "replace",
      [](const T& self, const py::object& settings) {
        return T{text::parse_settings_file(text::to_toml(self.settings), "settings",
                                           overrides_of(settings))};
      },
      py::arg("settings"),
      R"(Settings with other values for some keys, in any unit of their kind; they are checked.

>>> import smaservo
>>> settings = smaservo.Settings.for_wire(smaservo.Wire.load("smartflex-76um"))
>>> settings.replace({"limits.current_mA": 125})["limits.current_A"]
0.125
)");
  type.def("check", &check_settings,
           "Raises ConfigError, which names two settings, if they contradict each other.");
  type.def(
      "to_toml", [](const T& self) { return text::to_toml(self.settings); },
      "The text of a settings file that is read back to the same values.");
  type.def("parameters", &all_settings, "All settings by path, in SI.");
  type.def("__getitem__", &get_item, py::arg("path"), "A setting by its path, in SI.");
  type.def("__setitem__", &set_item, py::arg("path"), py::arg("value"),
           "Sets a setting by its path, in SI; its range is checked.");
  type.def_property_readonly(
      "wire",
      [](const T& self) {
        return files::WireDescription{"wire of the settings", self.settings.wire, {}};
      },
      "The wire, its numbers rounded to 32 bits.");
  type.def(
      "copy", [](const T& self) { return T(self); }, "Settings that may be changed by themselves.");
  type.def("__copy__", [](const T& self) { return T(self); });
  type.def(
      "__deepcopy__", [](const T& self, const py::object&) { return T(self); }, py::arg("memo"));
  type.def(
      "__eq__",
      [](const T& self, const py::object& other) -> py::object {
        if (!py::isinstance<T>(other)) {
          return py::reinterpret_borrow<py::object>(Py_NotImplemented);
        }
        return py::bool_(same_settings(self.settings, other.cast<const T&>().settings));
      },
      py::arg("other"));
  type.attr("__hash__") = py::none();
  // Settings that contradict each other are settings, too, until they are used: no file's text.
  // The rows that say which others are used come before them.
  type.def(py::pickle(&all_settings, [](const py::dict& state) {
    T self{default_settings<double>()};
    for (const auto& [path, value] : state) {
      const SettingRow& row = row_of(path.cast<std::string>());
      const auto number = value_in(row, py::reinterpret_borrow<py::object>(value));
      if (!number) {
        throw py::value_error(
            fmt::format("the pickled settings have no value of {} that is one", row.path.text()));
      }
      row.set(self.settings, *number);
    }
    return self;
  }));
}

}  // namespace smaservo::python
