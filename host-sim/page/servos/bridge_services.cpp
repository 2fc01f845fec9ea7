// The services of PROTOCOL.md. Those that need no bus answer at once, in the caller's thread; the
// others become jobs of the bus's thread.

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <limits>
#include <nlohmann/json.hpp>

#include "firmware/text/fault_reference.hpp"
#include "host-sim/can/bus/network.hpp"
#include "host-sim/choose/output.hpp"
#include "host-sim/page/servos/bridge.hpp"
#include "host-sim/page/servos/messages/requests.hpp"
#include "host-sim/page/servos/messages/schemas.hpp"
#include "host-sim/page/servos/messages/tables.hpp"
#include "model/files/error.hpp"
#include "model/files/message.hpp"

namespace smaservo::page {
namespace {

using files::UserError;
using nlohmann::json;

enum class Kind : std::uint8_t {
  at_once,   ///< needs no bus
  apart,     ///< needs no bus, and takes long
  rights,    ///< changes who has control, or stops, or is of the client that leads a run
  reading,   ///< allowed for any client
  changing,  ///< allowed for any client that is not read-only
  writing,   ///< needs control
};

struct ServiceRow {
  const char* name;
  Kind kind;
  const char* request;  ///< members of the request, as for request_schema()
};

constexpr auto service_rows = std::to_array<ServiceRow>({
    {"describe", Kind::at_once, ""},
    {"history", Kind::at_once, "node:integer seconds:number points:integer"},
    {"explain", Kind::at_once, "fault:string"},
    {"export", Kind::at_once, "recording:integer as:string"},
    {"take_control", Kind::rights, ""},
    {"release_control", Kind::rights, ""},
    {"stop", Kind::rights, ""},
    {"scan", Kind::reading, ""},
    {"dump", Kind::reading, "node:integer as:string"},
    {"diff", Kind::reading, "node:integer toml:string"},
    {"record", Kind::changing,
     "node:integer signals:strings seconds:number before_s?:number trigger?:string "
     "patience_s?:number"},
    {"enable", Kind::writing, "node:integer"},
    {"disable", Kind::writing, "node:integer"},
    {"reset_faults", Kind::writing, "node:integer"},
    {"mode", Kind::writing, "node:integer mode:integer"},
    {"target", Kind::writing, "node:integer value:number"},
    {"try", Kind::writing, "node:integer values:object seconds:number"},
    {"commit", Kind::writing, "node:integer"},
    {"revert", Kind::writing, "node:integer"},
    {"store", Kind::writing, "node:integer"},
    {"restore", Kind::writing, "node:integer toml:string"},
    {"step", Kind::writing, "node:integer amplitude_um:number seconds:number"},
    {"commission", Kind::writing,
     "node:integer readings?:integer reading_sd_m?:number pace?:number"},
    {"commission_answer", Kind::rights, "reading?:string"},
    {"commission_cancel", Kind::rights, ""},
    {"commission_file", Kind::at_once, "as:string"},
    {"choose", Kind::apart,
     "force_N:number stroke_m:number time_s:number length_m?:number supply_V?:number "
     "ambient_K?:number fan_m_s?:number one_way?:boolean spring_N?:number spring_N_m?:number "
     "life?:string parallel?:integer"},
});

constexpr std::size_t most_points = 20'000;
constexpr double longest_recording_s = 3600;
constexpr double usual_patience_s = 60;
constexpr std::int64_t scan_listen_us = 300'000;

json explained(const json& request) {
  const std::string name = text_in(request, "fault");
  const Fault fault = text::find_fault(name);
  if (fault == Fault::none) {
    throw UserError(fmt::format("{}: no such fault; similar are: {}", files::printable(name),
                                fmt::join(text::similar_faults(name), ", ")));
  }
  return {{"text", text::explain_fault(fault)}};
}

}  // namespace

std::vector<Service> Bridge::services() {
  std::vector<Service> all;
  all.reserve(service_rows.size());
  for (std::uint32_t i = 0; i < service_rows.size(); ++i) {
    all.push_back(
        {i + 1, service_rows[i].name, request_schema(service_rows[i].request), answer_schema()});
  }
  return all;
}

void Bridge::call(Caller caller, std::uint32_t service, std::string request,
                  std::function<void(Answer)> reply) {
  try {
    if (service == 0 || service > service_rows.size()) {
      throw UserError(fmt::format("service {}: there is no such service", service));
    }
    const ServiceRow& row = service_rows[service - 1];
    // The stop ignores the content of its request.
    if (row.name == std::string_view("stop")) {
      stop_everything(reply);
      return;
    }
    const json parsed = parsed_request(request);
    if (row.kind == Kind::changing && caller.read_only) {
      throw UserError(read_only_refusal);
    }
    if (row.kind == Kind::apart) {
      choose(parsed, reply);
    } else if (!call_at_once(caller, row.name, parsed, reply)) {
      queue(caller, row.name, parsed, reply);
    }
  } catch (const std::exception& error) {
    reply({false, error.what()});
  }
}

/// Computes in a thread of its own: neither the bus nor other clients wait.
void Bridge::choose(const json& request, const Reply& reply) {
  const bool begun = background_.run([this, task = chosen_task(request), reply] {
    Answer answer{true, ""};
    try {
      answer.text = json_text(
          choose::json(choose::choose_wires(task, [this] { return background_.ended(); })));
    } catch (const std::exception& error) {
      answer = {false, error.what()};
    }
    reply(answer);
  });
  if (!begun) {
    throw UserError("choose: too many ask at once; try again");
  }
}

/// Switches all off; the bus's thread confirms when each servo has confirmed.
void Bridge::stop_everything(const Reply& reply) {
  NodeSet nodes = control_.stop_all();
  {
    const std::scoped_lock lock(mutex_);
    nodes |= all_nodes_;
    stops_.emplace_back(reply, nodes);
  }
  switch_off(nodes);
}

bool Bridge::call_at_once(const Caller& caller, const std::string& service, const json& request,
                          const Reply& reply) {
  const auto told = [&] {
    const std::optional<std::uint32_t> client = control_.client();
    return json{{"control", client ? json(*client) : json(nullptr)}};
  };
  json answer;
  if (service == "describe") {
    static const std::string text = json_text(described());
    reply({true, text});
    return true;
  }
  if (service == "history") {
    answer = history(request);
  } else if (service == "explain") {
    answer = explained(request);
  } else if (service == "export") {
    answer = recordings_.exported(request);
  } else if (service == "commission_file") {
    answer = commissioner_.file(request);
  } else if (service == "commission_answer") {
    commissioner_.answer(caller.client, request, reply);
    return true;
  } else if (service == "commission_cancel") {
    cancel_commission(caller.client);
    answer = json::object();
  } else if (service == "take_control") {
    if (caller.read_only) {
      throw UserError(read_only_refusal);
    }
    switch_off(control_.take(caller.client),
               fmt::format("client {} has taken control", caller.client));
    answer = told();
  } else if (service == "release_control") {
    switch_off(control_.give_up(caller.client),
               fmt::format("client {} has given control up", caller.client));
    answer = told();
  } else {
    return false;
  }
  reply({true, json_text(answer)});
  return true;
}

json Bridge::history(const json& request) {
  const unsigned node = node_in(request);
  const double seconds = number_in(request, "seconds", 0, 1e6);
  const double points = number_in(request, "points", 2, static_cast<double>(most_points));
  std::shared_ptr<History> history;
  {
    const std::scoped_lock lock(mutex_);
    const auto found = shown_.find(node);
    if (found == shown_.end()) {
      throw UserError(fmt::format("node {}: no such servo", node));
    }
    history = found->second.history;
  }
  return history_message(
      history->last(static_cast<std::int64_t>(seconds * 1e6), static_cast<std::size_t>(points)),
      wall_ns(0));
}

void Bridge::queue(const Caller& caller, const std::string& service, const json& request,
                   Reply reply) {
  const auto* const row = std::ranges::find(service_rows, service, &ServiceRow::name);
  Job job{service, caller.client, 0, {}, std::move(reply)};
  if (row->kind == Kind::writing) {
    const Control::Leave leave = control_.ask(caller);
    if (!leave.refusal.empty()) {
      throw UserError(leave.refusal);
    }
    job.ticket = leave.ticket;
  }
  if (service != "disable") {
    require_free_bus();
  }
  if (service == "commission") {
    commissioner_.begin(caller.client, commission_task(request));
    const Job asked{service, job.client, job.ticket, {}, job.reply};
    job.run = [this, service, request, asked] {
      work(service, request, asked);
      return std::string();
    };
    // As for `record`: the answer comes when the wire is fitted.
    job.reply = [this, reply_ = job.reply](const Answer& answer) {
      if (!answer.ok) {
        commissioner_.failed(answer.text);
        reply_(answer);
      }
    };
  } else if (service == "record") {
    job.run = [this, caller, request, reply_ = job.reply] {
      begin_recording(caller, request, reply_);
      return std::string();
    };
    // The answer comes when the recording is complete; only an error is sent before.
    job.reply = [reply_ = job.reply](const Answer& answer) {
      if (!answer.ok) {
        reply_(answer);
      }
    };
  } else {
    const Job asked{service, job.client, job.ticket, {}, {}};
    job.run = [this, service, request, asked] { return json_text(work(service, request, asked)); };
  }
  if (service == "disable") {
    const NodeSet node = NodeSet{}.set(node_in(request));
    commissioner_.ends(node_in(request));
    off_switch_.off(node & all_nodes());
    if (activity_node_ == static_cast<int>(node_in(request))) {
      bus_.interrupt();
    }
  }
  const std::scoped_lock lock(mutex_);
  jobs_.push_back(std::move(job));
}

NodeSet Bridge::all_nodes() const {
  const std::scoped_lock lock(mutex_);
  return all_nodes_;
}

json Bridge::work(const std::string& service, const json& request, const Job& job) {
  if (service == "scan") {
    return scan();
  }
  Servo& servo = operations_.servo(node_in(request));
  if (!servo.joined) {
    operations_.join(servo);
  }
  activity_ = Activity{service, servo.node, job.client, bus_.now_us(), 0};
  activity_node_ = static_cast<int>(servo.node);
  try {
    json answer = work_on(servo, service, request, job);
    activity_node_ = 0;
    traffic_.refresh(servo.node);
    return answer;
  } catch (...) {
    activity_node_ = 0;
    throw;
  }
}

json Bridge::work_on(Servo& servo, const std::string& service, const json& request,
                     const Job& job) {
  json answer = json::object();
  if (service == "enable" || service == "step") {
    return heat(servo, service, request, job);
  }
  if (service == "commission") {
    commission(servo, job);
  } else if (service == "disable") {
    operations_.disable(servo);
  } else if (service == "reset_faults") {
    operations_.reset_faults(servo);
  } else if (service == "mode") {
    const double mode = number_in(request, "mode", -128, 127);
    if (mode != std::floor(mode)) {
      throw UserError("mode: must be a whole number");
    }
    operations_.set_mode(servo, static_cast<int>(mode));
  } else if (service == "target") {
    constexpr auto max = static_cast<double>(std::numeric_limits<float>::max());
    operations_.set_target(servo, number_in(request, "value", -max, max));
  } else if (service == "try") {
    operations_.try_for(servo, values_in(request), number_in(request, "seconds", 0.1, 3600));
    trial_ = {servo.node, job.client};
  } else if (service == "commit" || service == "revert") {
    service == "commit" ? operations_.commit(servo) : operations_.revert(servo);
    trial_.reset();
  } else if (service == "store") {
    operations_.store(servo);
  } else if (service == "dump") {
    answer["text"] = operations_.dump(servo, text_in(request, "as"));
  } else if (service == "diff") {
    answer = operations_.diff(servo, text_in(request, "toml"));
  } else if (service == "restore") {
    answer = operations_.restore(servo, text_in(request, "toml"));
  }
  return answer;
}

/// Runs a service that may heat: if anything fails, the axis is switched off.
json Bridge::heat(Servo& servo, const std::string& service, const json& request, const Job& job) {
  const NodeSet node = NodeSet{}.set(servo.node);
  std::int32_t amplitude_um = 0;
  double seconds = 0;
  if (service == "step") {
    const double amplitude = number_in(request, "amplitude_um", -1e6, 1e6);
    amplitude_um = static_cast<std::int32_t>(std::lround(amplitude));
    if (amplitude_um == 0) {
      throw UserError("amplitude_um: must not be 0");
    }
    seconds = number_in(request, "seconds", 0.2, 600);
    activity_->expected_us = static_cast<std::int64_t>(2e6 * seconds) + 2'000'000;
    for (const Recorded& running : recorded_) {
      if (running.recording.node() == servo.node) {
        throw UserError(fmt::format("{}: a recording is running; a step test needs the recorder",
                                    servo.title()));
      }
    }
  }
  try {
    json answer = json::object();
    if (service == "step") {
      const Operations::Step step = operations_.step(servo, job.ticket, amplitude_um, seconds);
      answer = {{"recording", recordings_.kept(step.recording, step.gains)},
                {"figures", step.figures},
                {"gains", step.gains}};
    } else {
      operations_.enable(servo, job.ticket);
    }
    return answer;
  } catch (...) {
    control_.cooled(servo.node);
    off_switch_.off(node);
    const std::scoped_lock lock(mutex_);
    to_check_ |= node;
    throw;
  }
}

// Commissioning.

/// While a run has the bus's thread, requests of others would wait for minutes, and then do
/// something that nobody expects any more.
void Bridge::require_free_bus() const {
  if (const std::optional<unsigned> node = commissioner_.node_on_bus()) {
    throw UserError(
        fmt::format("node {} is being commissioned, and the bridge does nothing else on the bus "
                    "until its heat is off",
                    *node));
  }
}

/// Records a guided run, and hands it over to be fitted.
void Bridge::commission(Servo& servo, const Job& job) {
  const NodeSet heated = control_.heated();
  for (unsigned node = 1; node < heated.size(); ++node) {
    if (heated[node]) {
      throw UserError(fmt::format("node {} is enabled: disable it first", node));
    }
  }
  for (const Recorded& running : recorded_) {
    if (running.recording.node() == servo.node) {
      throw UserError(fmt::format("{}: a recording is running; commissioning needs the recorder",
                                  servo.title()));
    }
  }
  if (trial_) {
    throw UserError("a trial is going on; keep it or revert it first");
  }
  if (!control_.heat(job.ticket, servo.node)) {
    throw UserError("control has passed on");
  }
  // Says from now on whether this run has commanded the servo.
  servo.commanded.word.reset();
  servo.enabled_us = 0;
  const auto look = [&] {
    if (ends_ || !control_.holds(job.ticket)) {
      throw Interrupted();
    }
    if (servo.commanded.word && servo.enabled_us == 0) {
      // Renewed from now on as an axis that a client has enabled.
      servo.enabled_us = bus_.now_us();
      operations_.shorten_watch(servo);
    }
  };
  try {
    Commissioner::Heated done = commissioner_.heat(operations_.remote(servo), look);
    leave_commissioned(servo);
    fit_commissioned(std::move(done), job.reply);
  } catch (...) {
    const bool commanded = servo.commanded.word.has_value();
    leave_commissioned(servo);
    if (commanded) {
      const std::scoped_lock lock(mutex_);
      to_check_.set(servo.node);
    } else if (ends_ || commissioner_.is_cancelled() || !control_.holds(job.ticket)) {
      // While the run listens for other masters, it hears this program's own off switch as one.
      throw Interrupted();
    }
    throw;
  }
}

void Bridge::leave_commissioned(Servo& servo) {
  servo.enabled_us = 0;
  control_.cooled(servo.node);
  // RPDO1 would bring the mode of the run back.
  off_switch_.knows_no_pdo(servo.node);
  traffic_.refresh(servo.node);
  try {
    operations_.put_back_watch(servo);
  } catch (const std::exception& error) {
    trouble(fmt::format("{}: {}", servo.title(), error.what()));  // tried again later
  }
}

/// In a thread of its own, as choose().
void Bridge::fit_commissioned(Commissioner::Heated heated, const Reply& reply) {
  const auto run = std::make_shared<const Commissioner::Heated>(std::move(heated));
  const bool begun = background_.run([this, run, reply] {
    try {
      commissioner_.fit(*run, [this] { return !background_.ended(); });
      reply({true, "{}"});
    } catch (const std::exception& error) {
      commissioner_.failed(error.what());
      reply({false, error.what()});
    }
  });
  if (!begun) {
    throw UserError("the run is recorded, but too many ask at once for the wire to be fitted");
  }
}

void Bridge::cancel_commission(std::uint32_t client) {
  if (const std::optional<unsigned> node = commissioner_.cancel(client)) {
    switch_off(NodeSet{}.set(*node));
  }
}

json Bridge::scan() {
  const can::FoundNodes found = can::scan(bus_, scan_listen_us);
  json nodes = json::array();
  for (const can::FoundNode& node : found.nodes) {
    nodes.push_back(
        {{"node", node.node},
         {"answers", node.answers},
         {"nmt", node.nmt_state ? json(can::nmt_state_text(*node.nmt_state)) : json()}});
    traffic_.probe(node.node);
  }
  return {{"nodes", nodes}, {"without_id", found.without_id}};
}

void Bridge::begin_recording(const Caller& caller, const json& request, const Reply& reply) {
  const Servo& servo = operations_.servo(node_in(request));
  for (const Recorded& running : recorded_) {
    if (running.recording.node() == servo.node) {
      throw UserError(
          fmt::format("{}: its recorder is at work for client {}", servo.title(), running.client));
    }
  }
  const double patience_s = request.contains("patience_s")
                                ? number_in(request, "patience_s", 0, longest_recording_s)
                                : usual_patience_s;
  // Constructed in place, because it refers to itself.
  recorded_.emplace_back(operations_.remote(servo), recording_plan(request, longest_recording_s),
                         patience_s, caller.client, reply);
}

}  // namespace smaservo::page
