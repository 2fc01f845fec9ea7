// python -m smaservo inspect, smaservo.inspect()

#include "host-sim/inspect/inspect.hpp"

#include <algorithm>

#include "host-sim/python/bindings/tables.hpp"

namespace smaservo::python {
namespace {

/// Text, JSON, and whether the file has a mistake.
py::tuple inspect_file(const std::string& path, const std::optional<std::string>& wire,
                       const py::object& settings, const hal::TraceOptions& trace) {
  inspect::InspectOptions options;
  options.trace = path;
  options.trace_options = trace;
  const std::vector<files::Override> overrides = overrides_of(settings);
  options.wire_given = wire.has_value() || !overrides.empty();
  if (wire) {
    options.wire_words = " --wire " + *wire;
  }
  for (const auto& [key, value] : overrides) {
    options.wire_words += fmt::format(" --set {}={}", key, value);
  }
  options.wire = files::load_wire(wire.value_or(std::string(files::default_wire)), overrides);
  inspect::Facts facts;
  {
    const py::gil_scoped_release no_gil;
    facts = inspect::inspect(options);
    facts.record = {};
  }
  const bool mistaken = std::ranges::any_of(facts.findings, &checks::Finding::is_error);
  const std::string text = inspect::text_of(facts, options);
  return py::make_tuple(text, inspect::json_of({facts}), mistaken);
}

}  // namespace

void add_inspect(py::module_& module) {
  module.def("inspect_file", [](const std::string& path, const std::optional<std::string>& wire,
                                const py::object& settings, const std::vector<std::string>& columns,
                                std::optional<double> period_s) {
    return inspect_file(path, wire, settings, trace_options(false, period_s, columns));
  });
}

}  // namespace smaservo::python
