// The extension module smaservo._core: the errors, and the sources that add the rest.

#include "host-sim/python/bindings/bindings.hpp"

#include <exception>
#include <utility>

#include "firmware/text/device_names.hpp"
#include "hal/replay/trace.hpp"
#include "model/files/error.hpp"
#include "model/files/message.hpp"

namespace smaservo::python {
namespace {

/// What a dict's value is as the value of a --set.
std::string text_of(const std::string& key, const py::handle& value) {
  if (py::isinstance<py::str>(value)) {
    return value.cast<std::string>();
  }
  if (py::isinstance<py::bool_>(value)) {
    return value.cast<bool>() ? "true" : "false";
  }
  if (py::isinstance<py::list>(value) || py::isinstance<py::tuple>(value)) {
    std::string all;
    for (const py::handle item : value) {
      all += (all.empty() ? "" : ", ") + text_of(key, item);
    }
    return "[" + all + "]";
  }
  if (PyIndex_Check(value.ptr()) != 0) {
    return py::str(py::int_(py::reinterpret_borrow<py::object>(value))).cast<std::string>();
  }
  if (PyNumber_Check(value.ptr()) != 0 && PyComplex_Check(value.ptr()) == 0) {
    return fmt::format("{}", py::float_(py::reinterpret_borrow<py::object>(value)).cast<double>());
  }
  throw py::type_error(fmt::format(
      "settings['{}'] is a {}: must be a number, a truth value, a text, or a list of numbers",
      files::printable(key), py::type::handle_of(value).attr("__name__").cast<std::string>()));
}

// The classes live as long as the interpreter, as those of any module.
struct Errors {
  PyObject *error, *user, *config, *trace, *no_result;
};
Errors& errors() {
  static Errors all{};
  return all;
}

/// Raises this error's Python class; what came from outside is escaped, since it may be no UTF-8.
void raise(PyObject* type, const std::exception& error) {
  PyErr_SetString(type, files::printable(error.what()).c_str());
}

void translate(std::exception_ptr thrown) {
  try {
    if (thrown) {
      std::rethrow_exception(std::move(thrown));
    }
  } catch (const files::ConfigError& error) {
    raise(errors().config, error);
  } catch (const files::UserError& error) {
    raise(errors().user, error);
  } catch (const hal::TraceError& error) {
    raise(errors().trace, error);
  } catch (const files::NoResult& error) {
    raise(errors().no_result, error);
  } catch (const files::Error& error) {
    raise(errors().error, error);
  }
}

}  // namespace

void add_errors(py::module_& module) {
  const auto add = [&](const char* name, const char* doc, const py::object& bases) {
    const std::string full = fmt::format("smaservo.{}", name);
    PyObject* const type = PyErr_NewExceptionWithDoc(full.c_str(), doc, bases.ptr(), nullptr);
    if (type == nullptr) {
      throw py::error_already_set();
    }
    module.add_object(name, type);
    return type;
  };
  const auto of = [](auto... types) {
    return py::make_tuple(py::reinterpret_borrow<py::object>(types)...);
  };
  Errors& all = errors();
  all.error =
      add("Error", "The root of all errors of smaservo: a message that names what and where.",
          of(PyExc_Exception));
  all.user =
      add("UserError", "A mistake that the message explains.", of(all.error, PyExc_ValueError));
  all.config = add("ConfigError", "A mistake in a file or a setting, which only a person can mend.",
                   of(all.user));
  all.trace =
      add("TraceError", "A recording that cannot be read; the message names file, line and column.",
          of(all.error, PyExc_ValueError));
  all.no_result = add("NoResult",
                      "What was asked has been done, but nobody can use the result: a fit that has "
                      "not converged.",
                      of(all.error));
  py::register_exception_translator(&translate);
}

std::vector<files::Override> overrides_of(const py::object& settings) {
  std::vector<files::Override> all;
  if (settings.is_none()) {
    return all;
  }
  if (!py::hasattr(settings, "items")) {
    throw py::type_error(
        fmt::format("settings is a {}: must be a dict such as "
                    "{{\"wire.length_mm\": 120}}",
                    py::type::handle_of(settings).attr("__name__").cast<std::string>()));
  }
  for (const py::handle item : settings.attr("items")()) {
    const auto [key, value] = item.cast<std::pair<py::object, py::object>>();
    if (!py::isinstance<py::str>(key)) {
      throw py::type_error("settings: its keys must be texts such as 'wire.length_mm'");
    }
    const auto name = key.cast<std::string>();
    all.emplace_back(name, text_of(name, value));
  }
  return all;
}

py::tuple names_of_faults(FaultSet set) {
  py::list names;
  for_each_fault(set, [&](Fault fault) { names.append(py::str(text::names_of(fault))); });
  return {names};
}

PYBIND11_MODULE(_core, module) {
  py::options options;
  options.disable_function_signatures();
  module.attr("__version__") = SMASERVO_VERSION;
  add_errors(module);
  add_wire(module);
  add_plant(module);
  add_estimator(module);
  add_settings(module);
  add_servo(module);
  add_tables(module);
  add_identify(module);
  add_evaluate(module);
  add_inspect(module);
}

}  // namespace smaservo::python
