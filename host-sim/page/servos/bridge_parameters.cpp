// Parameters of the protocol, and those in a request.

#include <algorithm>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "host-sim/page/servos/bridge.hpp"
#include "host-sim/page/servos/messages/tables.hpp"
#include "model/files/error.hpp"

namespace smaservo::page {

namespace {

using files::UserError;
using nlohmann::json;

}  // namespace

std::vector<Operations::NewValue> Bridge::values_in(const json& request) {
  const auto values = request.find("values");
  if (values == request.end() || !values->is_object() || values->empty()) {
    throw UserError("values: must be an object {NAME: VALUE, ...}");
  }
  std::vector<Operations::NewValue> all;
  for (const auto& [name, value] : values->items()) {
    const std::size_t row = parameter_row(name);
    all.push_back({row, parameter_text(parameters<double>[row], value)});
  }
  return all;
}

std::vector<NamedValue> Bridge::values_of(unsigned node, const std::vector<std::size_t>& rows) {
  std::shared_ptr<KnownParameters> known;
  {
    const std::scoped_lock lock(mutex_);
    const auto found = shown_.find(node);
    if (found == shown_.end()) {
      return {};
    }
    known = found->second.parameters;
  }
  std::vector<NamedValue> values;
  for (std::size_t row = 0; row < parameter_count; ++row) {
    if (!rows.empty() && std::ranges::find(rows, row) == rows.end()) {
      continue;
    }
    const Parameter<double>& parameter = parameters<double>[row];
    if (const std::optional<Value> value = known->get(row)) {
      values.push_back({fmt::format("node{}.{}", node, parameter.path.text()),
                        parameter_json(parameter, *value)});
    }
  }
  return values;
}

/// Sends the values of these rows; if there are none, those of all rows.
void Bridge::tell_parameters(unsigned node, const std::vector<std::size_t>& rows) {
  if (Sink* sink = sink_) {
    sink->parameters_changed(values_of(node, rows));
  }
}

void Bridge::get_parameters(std::vector<std::string> names,
                            std::function<void(std::vector<NamedValue>)> reply) {
  std::vector<NamedValue> values;
  if (names.empty()) {
    const NodeSet nodes = all_nodes();
    for (unsigned node = 1; node < nodes.size(); ++node) {
      if (!nodes[node]) {
        continue;
      }
      for (NamedValue& value : values_of(node, {})) {
        values.push_back(std::move(value));
      }
    }
  }
  for (const std::string& name : names) {
    try {
      const ParameterName parameter = parameter_of(name);
      for (NamedValue& value : values_of(parameter.node, {parameter.row})) {
        values.push_back(std::move(value));
      }
    } catch (const UserError&) {
      continue;  // a parameter that does not exist is left out, because the protocol has no place
                 // for a reason
    }
  }
  reply(std::move(values));
}

void Bridge::write_parameters(unsigned node, const std::vector<Operations::NewValue>& values) {
  Servo& servo = operations_.servo(node);
  operations_.write(servo, values);
  std::vector<std::size_t> rows;
  rows.reserve(values.size());
  for (const Operations::NewValue& value : values) {
    rows.push_back(value.row);
  }
  operations_.read_parameters(servo, rows);
}

void Bridge::set_parameters(
    Caller caller, std::vector<NamedValue> values,
    std::function<void(std::vector<NamedValue>, std::string refusal)> reply) {
  std::vector<std::string> names;
  names.reserve(values.size());
  for (const NamedValue& value : values) {
    names.push_back(value.name);
  }
  // The values in force are sent back, whatever the result.
  const Reply answer = [this, names, reply](const Answer& result) {
    get_parameters(names, [&](std::vector<NamedValue> in_force) {
      reply(names.empty() ? std::vector<NamedValue>{} : std::move(in_force),
            result.ok ? "" : result.text);
    });
  };
  try {
    unsigned node = 0;
    std::vector<Operations::NewValue> wanted;
    for (const NamedValue& value : values) {
      const ParameterName name = parameter_of(value.name);
      if (node != 0 && name.node != node) {
        throw UserError("a set of parameters must be of one servo: two cannot change together");
      }
      node = name.node;
      const json parsed = json::parse(value.value, nullptr, false);
      if (parsed.is_discarded()) {
        throw UserError(fmt::format("{}: is no JSON", value.name));
      }
      wanted.push_back({name.row, parameter_text(parameters<double>[name.row], parsed)});
    }
    if (wanted.empty()) {
      throw UserError("no parameters");
    }
    const Control::Leave leave = control_.ask(caller);
    if (!leave.refusal.empty()) {
      throw UserError(leave.refusal);
    }
    require_free_bus();
    Job job{"setParameters", caller.client, leave.ticket, {}, answer};
    job.run = [this, node, wanted] {
      write_parameters(node, wanted);
      return std::string();
    };
    const std::scoped_lock lock(mutex_);
    jobs_.push_back(std::move(job));
  } catch (const std::exception& error) {
    answer({false, error.what()});
  }
}

}  // namespace smaservo::page
