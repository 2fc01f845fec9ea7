#pragma once
// The members of a client's request. Each function throws UserError, which names the member and
// what it must be.

#include <nlohmann/json.hpp>
#include <string>

#include "host-sim/can/bus/recorder.hpp"

namespace smaservo::page {

nlohmann::json parsed_request(const std::string& text);
unsigned node_in(const nlohmann::json& request);
double number_in(const nlohmann::json& request, const char* name, double low, double high);
std::string text_in(const nlohmann::json& request, const char* name);

/// What `record` is asked for, of at most so many seconds.
can::RecordingPlan recording_plan(const nlohmann::json& request, double longest_s);
/// A recording as recording_message() has made it.
can::Recording recording_of(const nlohmann::json& message);

}  // namespace smaservo::page
