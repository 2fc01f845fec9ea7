#include "host-sim/page/servos/messages/requests.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

#include "firmware/text/canopen/objects.hpp"
#include "firmware/text/signal_names.hpp"
#include "host-sim/page/servos/messages/tables.hpp"
#include "model/files/error.hpp"
#include "model/files/message.hpp"
#include "model/units.hpp"

namespace smaservo::page {

using files::UserError;
using nlohmann::json;

json parsed_request(const std::string& text) {
  json request = json::parse(text, nullptr, false);
  if (!request.is_object()) {
    throw UserError("the request must be a JSON object");
  }
  return request;
}

unsigned node_in(const json& request) {
  const double node = number_in(request, "node", 1, 127);
  if (node != std::floor(node)) {
    throw UserError("node: must be a whole number from 1 to 127");
  }
  return static_cast<unsigned>(node);
}

double number_in(const json& request, const char* name, double low, double high) {
  const auto found = request.find(name);
  const bool good = found != request.end() && found->is_number();
  const double value = good ? found->get<double>() : std::nan("");
  if (!(low <= value && value <= high)) {
    throw UserError(fmt::format(
        "{}{}: must be a number from {} to {}", name,
        found == request.end() ? " is missing" : " = " + files::printable(json_text(*found)), low,
        high));
  }
  return value;
}

std::string text_in(const json& request, const char* name) {
  const auto found = request.find(name);
  if (found == request.end() || !found->is_string()) {
    throw UserError(fmt::format("{}: must be a string", name));
  }
  return found->get<std::string>();
}

choose::Task chosen_task(const json& request) {
  constexpr double any = 1e12;  // choose_wires() knows the ranges
  const auto optional = [&](const char* name) {
    return request.contains(name) ? std::optional(number_in(request, name, -any, any))
                                  : std::nullopt;
  };
  choose::Task task{.force_N = number_in(request, "force_N", -any, any),
                    .stroke_m = number_in(request, "stroke_m", -any, any),
                    .time_s = number_in(request, "time_s", -any, any),
                    .length_m = optional("length_m"),
                    .spring = {},
                    .supply_V = optional("supply_V"),
                    .ambient_K = optional("ambient_K").value_or(room_K)};
  if (const auto fan_m_s = optional("fan_m_s")) {
    task.fan_m_s = *fan_m_s;
  }
  const auto preload_N = optional("spring_N");
  const auto rate_N_m = optional("spring_N_m");
  if (preload_N.has_value() != rate_N_m.has_value()) {
    throw UserError("spring_N and spring_N_m: one needs the other");
  }
  if (preload_N) {
    task.spring = choose::Spring{*preload_N, *rate_N_m};
  }
  if (request.contains("one_way")) {
    if (!request["one_way"].is_boolean()) {
      throw UserError("one_way: must be true or false");
    }
    task.one_way = request["one_way"].get<bool>();
  }
  if (request.contains("life")) {
    task.life = choose::life_of(text_in(request, "life"));
  }
  if (request.contains("parallel")) {
    const double parallel = number_in(request, "parallel", 1, choose::most_parallel);
    if (parallel != std::floor(parallel)) {
      throw UserError("parallel: must be a whole number");
    }
    task.parallel = static_cast<int>(parallel);
  }
  return task;
}

CommissionTask commission_task(const json& request) {
  CommissionTask task;
  task.node = node_in(request);
  if (request.contains("readings")) {
    const double readings = number_in(request, "readings", 0, commission::most_questions);
    if (readings != std::floor(readings)) {
      throw UserError("readings: must be a whole number");
    }
    task.readings = static_cast<std::size_t>(readings);
  }
  if (request.contains("reading_sd_m")) {
    task.reading_sd_m = number_in(request, "reading_sd_m", 1e-6, 1);
  }
  if (request.contains("pace")) {
    task.pace = number_in(request, "pace", 0.05, 2);
  }
  return task;
}

can::RecordingPlan recording_plan(const json& request, double longest_s) {
  can::RecordingPlan plan;
  plan.seconds = number_in(request, "seconds", 0.001, longest_s);
  if (request.contains("before_s")) {
    plan.before_s = number_in(request, "before_s", 0, longest_s);
  }
  if (request.contains("trigger") && !request["trigger"].is_null()) {
    plan.trigger = text_in(request, "trigger");
  }
  const auto signals = request.find("signals");
  if (signals == request.end() || !signals->is_array()) {
    throw UserError("signals: must be a list of names");
  }
  for (const json& signal : *signals) {
    if (!signal.is_string()) {
      throw UserError("signals: must be a list of names");
    }
    plan.signals.push_back(signal.get<std::string>());
  }
  return plan;
}

can::Recording recording_of(const json& message) {
  if (!message.is_object() || !message.contains("signals") || !message["signals"].is_array() ||
      !message.contains("rows") || !message["rows"].is_array()) {
    throw UserError("recording: must be what `record` or `step` has answered");
  }
  can::Recording recording;
  recording.period_s = number_in(message, "period_s", 1e-6, 1e6);
  for (const json& signal : message["signals"]) {
    recording.signals.push_back(signal.is_string() ? signal.get<std::string>()
                                                   : files::printable(json_text(signal)));
    try {
      text::signal_row(recording.signals.back());
    } catch (const UserError& error) {
      throw UserError(fmt::format("recording: signals: {}", error.what()));
    }
  }
  for (const json& values : message["rows"]) {
    std::vector<double>& row = recording.rows.emplace_back();
    for (const json& value : values) {
      row.push_back(value.is_number() ? value.get<double>() : std::nan(""));
    }
    if (!values.is_array() || row.size() != recording.signals.size()) {
      throw UserError(fmt::format("recording: row {}: must have {} values", recording.rows.size(),
                                  recording.signals.size()));
    }
  }
  return recording;
}

}  // namespace smaservo::page
