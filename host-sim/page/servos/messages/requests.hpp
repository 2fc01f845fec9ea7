#pragma once
// The members of a client's request. Each function throws UserError, which names the member and its
// allowed values.

#include <nlohmann/json.hpp>
#include <string>

#include "host-sim/can/bus/recorder.hpp"
#include "host-sim/choose/choose.hpp"
#include "host-sim/commission/live/sequence.hpp"

namespace smaservo::page {

nlohmann::json parsed_request(const std::string& text);
unsigned node_in(const nlohmann::json& request);
double number_in(const nlohmann::json& request, const char* name, double low, double high);
std::string text_in(const nlohmann::json& request, const char* name);

/// What `choose` is asked for.
choose::Task chosen_task(const nlohmann::json& request);
/// What `commission` is asked for.
struct CommissionTask {
  unsigned node = 1;
  std::size_t readings = 1;  ///< of the heated wire; 0: nothing is asked
  double reading_sd_m = 0.1e-3;
  double pace = 1;  ///< factor on the durations of all levels
};
CommissionTask commission_task(const nlohmann::json& request);
/// The plan of a recording that `record` is asked for, of at most `longest_s`.
can::RecordingPlan recording_plan(const nlohmann::json& request, double longest_s);
/// The recording of a message made by recording_message().
can::Recording recording_of(const nlohmann::json& message);

}  // namespace smaservo::page
