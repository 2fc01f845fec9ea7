#pragma once
// The members of a client's request. Each function throws UserError, which names the member and its
// allowed values.

#include <nlohmann/json.hpp>
#include <string>

#include "host-sim/can/bus/recorder.hpp"
#include "host-sim/choose/choose.hpp"

namespace smaservo::page {

nlohmann::json parsed_request(const std::string& text);
unsigned node_in(const nlohmann::json& request);
double number_in(const nlohmann::json& request, const char* name, double low, double high);
std::string text_in(const nlohmann::json& request, const char* name);

/// What `choose` is asked for.
choose::Task chosen_task(const nlohmann::json& request);
/// The plan of a recording that `record` is asked for, of at most `longest_s`.
can::RecordingPlan recording_plan(const nlohmann::json& request, double longest_s);
/// The recording of a message made by recording_message().
can::Recording recording_of(const nlohmann::json& message);

}  // namespace smaservo::page
