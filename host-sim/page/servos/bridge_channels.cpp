// The channels of the bridge, and their content.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "host-sim/page/servos/bridge.hpp"
#include "host-sim/page/servos/messages/schemas.hpp"
#include "host-sim/page/servos/messages/tables.hpp"
#include "model/files/message.hpp"

namespace smaservo::page {
namespace {

using nlohmann::json;

constexpr std::uint32_t bridge_channel = 1;
constexpr std::uint32_t commission_channel = 2;
constexpr std::uint32_t live_channel = 1000;   ///< plus the node-id
constexpr std::uint32_t state_channel = 2000;  ///< plus the node-id
constexpr std::uint32_t ros_channel = 3000;  ///< plus the node-id: live values for readers of ROS 2

constexpr std::int64_t bridge_period_us = 250'000;
/// Of smaservo.Commission while no wire is commissioned.
constexpr std::int64_t idle_commission_period_us = 1'000'000;
/// Live values are still read for this time after the last page has gone, so that a reload misses
/// nothing.
constexpr std::int64_t linger_us = 60'000'000;
/// A message about trouble with the bus is shown for at least this time.
constexpr std::int64_t shortest_trouble_us = 1'000'000;

const char* stage_name(can::RecorderStage stage) {
  switch (stage) {
    case can::RecorderStage::filling:
      return "filling";
    case can::RecorderStage::waiting:
      return "waiting";
    case can::RecorderStage::recording:
      return "recording";
    case can::RecorderStage::complete:
      return "complete";
  }
  return "";
}

}  // namespace

// Channels.

std::vector<Channel> Bridge::channels() {
  static const std::string bridge = bridge_schema();
  static const std::string live = live_schema();
  static const std::string state = state_schema();
  static const std::string definition = live_definition();
  static const std::string commission = commission_schema();
  std::vector<Channel> all{{bridge_channel, "/bridge", "smaservo.Bridge", bridge},
                           {commission_channel, "/commission", "smaservo.Commission", commission}};
  const std::scoped_lock lock(mutex_);
  for (const auto& [node, shown] : shown_) {
    all.push_back({live_channel + node, fmt::format("/node{}/live", node), "smaservo.Live", live});
    all.push_back(
        {state_channel + node, fmt::format("/node{}/state", node), "smaservo.State", state});
    all.push_back({ros_channel + node, fmt::format("/node{}/signals", node),
                   "smaservo_msgs/msg/Live", definition, Encoding::cdr});
  }
  return all;
}

void Bridge::subscribed(std::uint32_t channel, unsigned clients) {
  const std::scoped_lock lock(mutex_);
  wanted_[channel] = clients;
}

bool Bridge::is_wanted(std::uint32_t channel) const {
  const std::scoped_lock lock(mutex_);
  const auto found = wanted_.find(channel);
  return found != wanted_.end() && found->second > 0;
}

/// Derives from the subscriptions what is read from the bus.
void Bridge::apply_wishes() {
  const std::int64_t now_us = bus_.now_us();
  NodeSet live;
  bool anything = control_.client().has_value();
  {
    const std::scoped_lock lock(mutex_);
    for (const auto& [channel, clients] : wanted_) {
      if (clients == 0) {
        continue;
      }
      anything = true;
      for (const std::uint32_t first : {live_channel, ros_channel}) {
        if (channel > first && channel < first + 128) {
          live_until_us_[channel - first] = now_us + linger_us;
        }
      }
    }
  }
  for (const auto& [node, until_us] : live_until_us_) {
    live.set(node, now_us < until_us);
  }
  traffic_.want(live, anything || live.any());
}

void Bridge::show(const Servo& servo) {
  {
    const std::scoped_lock lock(mutex_);
    shown_[servo.node] = {servo.history, servo.parameters};
    all_nodes_.set(servo.node);
  }
  if (Sink* sink = sink_) {
    sink->channels_changed();
  }
}

// Events of the traffic.

void Bridge::sampled(Servo& servo, const Sample& sample) {
  servo.history->add(sample);
  Sink* const sink = sink_;
  if (sink == nullptr) {
    return;
  }
  const std::int64_t time_ns = wall_ns(sample.time_us);
  sink->message(live_channel + servo.node, time_ns,
                std::make_shared<const std::string>(live_text(sample)));
  if (!is_wanted(ros_channel + servo.node)) {
    return;
  }
  // The message has all signals, each with its last reading.
  sink->message(
      ros_channel + servo.node, time_ns,
      std::make_shared<const std::string>(live_bytes(servo.history->newest().value_or(sample))));
}

void Bridge::state_read(Servo& servo) {
  if (servo.commanded.by_pdo) {
    off_switch_.knows_pdo(servo.node, static_cast<std::int8_t>(servo.mode()));
  } else {
    off_switch_.knows_no_pdo(servo.node);
  }
  const bool has_cause = servo.value({0x2202, 9}) != 0;
  if (!has_cause) {
    servo.freeze_frame.reset();
  } else if (!servo.freeze_frame) {
    servo.freeze_frame = servo.history->newest();
  }
  if (Sink* sink = sink_) {
    sink->message(state_channel + servo.node, wall_ns(bus_.now_us()),
                  std::make_shared<const std::string>(json_text(state_message(servo))));
  }
}

void Bridge::came(unsigned node) {
  Servo& servo = traffic_.servos().try_emplace(node, node).first->second;
  servo.online = true;
  servo.joined = false;
  next_try_us_[node] = 0;
}

void Bridge::left(Servo& servo) {
  servo.left_us = bus_.now_us();
  if (control_.heated()[servo.node]) {
    control_.cooled(servo.node);
    // Perhaps only the bus has failed: the servo's own watch ends the heat, and the servo is asked
    // when it is back.
    const std::scoped_lock lock(mutex_);
    to_check_.set(servo.node);
  }
  stream_.forget(servo.node);
  published_us_ = 0;
  state_read(servo);
}

void Bridge::restarted(Servo& servo) {
  control_.cooled(servo.node);
  servo.enabled_us = 0;
  servo.values.clear();
  servo.commanded = {};
  servo.joined = false;
  servo.usual_timeout_s.reset();
  stream_.forget(servo.node);
  next_try_us_[servo.node] = 0;
  const std::scoped_lock lock(mutex_);
  to_check_.reset(servo.node);
}

void Bridge::doubled(Servo& servo) {
  published_us_ = 0;
  const NodeSet node = NodeSet{}.set(servo.node);
  if (control_.heated()[servo.node]) {
    control_.cooled(servo.node);
    off_switch_.off(node);
  }
}

void Bridge::trouble(const std::string& text) {
  trouble_us_ = bus_.now_us();
  if (trouble_ == text) {
    return;
  }
  trouble_ = text;
  published_us_ = 0;
}

void Bridge::watch_clients(std::int64_t now_us) {
  take_wall_clock(now_us);
  Sink* const sink = sink_;
  const std::optional<std::uint32_t> client = control_.client();
  if (sink == nullptr || !client) {
    return;
  }
  const std::vector<ClientState> all = sink->clients();
  if (std::ranges::find(all, *client, &ClientState::client) == all.end()) {
    client_left(*client);
  }
}

/// Detects that a busy computer has kept this program from running. That is no fault of a servo,
/// but it may have ended the servo's heat.
void Bridge::watch_own_lateness(std::int64_t now_us) {
  constexpr std::int64_t late_us = 500'000;
  const std::int64_t gone_us = ticked_us_ == 0 ? 0 : now_us - ticked_us_;
  ticked_us_ = now_us;
  if (gone_us < late_us) {
    return;
  }
  const std::string text = fmt::format(
      "this computer is too busy: host-sim page did not run for {:.1f} s, and a servo that it "
      "heats may have gone off by that",
      static_cast<double>(gone_us) * 1e-6);
  files::complain("host-sim", "page: " + text);
  trouble(text);
}

void Bridge::ticked(std::int64_t now_us) {
  watch_own_lateness(now_us);
  if (now_us - published_us_ >= bridge_period_us) {
    watch_clients(now_us);
    publish_bridge(now_us);
  }
  publish_commission(now_us);
}

/// At each change, and from time to time for whoever has come since.
void Bridge::publish_commission(std::int64_t now_us) {
  const std::int64_t period_us =
      commissioner_.is_busy() ? bridge_period_us : idle_commission_period_us;
  if (!commissioner_.has_changed() && now_us - commission_us_ < period_us) {
    return;
  }
  commission_us_ = now_us;
  Sink* const sink = sink_;
  if (sink != nullptr && is_wanted(commission_channel)) {
    sink->message(commission_channel, wall_ns(now_us),
                  std::make_shared<const std::string>(commissioner_.message(now_us)));
  }
}

void Bridge::publish_bridge(std::int64_t now_us) {
  published_us_ = now_us;
  if (now_us - trouble_us_ > shortest_trouble_us) {
    trouble_.clear();
  }
  if (Sink* sink = sink_) {
    sink->message(bridge_channel, wall_ns(now_us),
                  std::make_shared<const std::string>(bridge_text(now_us)));
  }
}

std::string Bridge::bridge_text(std::int64_t now_us) {
  json message{{"bus", port_->name()}, {"read_only", plan_.read_only}, {"trouble", trouble_}};
  message["nodes"] = json::array();
  for (const auto& [node, servo] : traffic_.servos()) {
    if (servo.name.empty() && !servo.duplicate) {
      continue;  // not known yet to be a servo
    }
    message["nodes"].push_back({{"node", node},
                                {"name", servo.name},
                                {"online", servo.online},
                                {"duplicate", servo.duplicate}});
  }
  const std::optional<std::uint32_t> client = control_.client();
  message["control"] = client ? json(*client) : json(nullptr);
  message["clients"] = json::array();
  Sink* const sink = sink_;
  for (const ClientState& c : sink != nullptr ? sink->clients() : std::vector<ClientState>{}) {
    message["clients"].push_back({{"client", c.client},
                                  {"address", c.address},
                                  {"queued", c.queued},
                                  {"dropped", c.dropped},
                                  {"read_only", c.read_only}});
  }
  message["activity"] = nullptr;
  if (activity_) {
    const double progress = activity_->expected_us <= 0
                                ? 0
                                : std::clamp(static_cast<double>(now_us - activity_->start_us) /
                                                 static_cast<double>(activity_->expected_us),
                                             0.0, 1.0);
    message["activity"] = {{"service", activity_->service},
                           {"node", activity_->node},
                           {"client", activity_->client},
                           {"progress", std::round(100 * progress) / 100}};
  }
  message["recordings"] = json::array();
  for (const Recorded& running : recorded_) {
    message["recordings"].push_back({{"node", running.recording.node()},
                                     {"client", running.client},
                                     {"stage", stage_name(running.recording.stage())}});
  }
  return json_text(message);
}

void Bridge::take_wall_clock(std::int64_t now_us) {
  if (now_us - wall_us_ < 1'000'000) {
    return;
  }
  wall_us_ = now_us;
  const std::int64_t wall = plan_.wall_ns() - 1000 * now_us;
  // Small differences are ignored, because times of messages must not go back.
  if (std::abs(wall - wall_ns_at_0_) > 100'000'000) {
    wall_ns_at_0_ = wall;
  }
}

std::int64_t system_wall_ns() {
  using namespace std::chrono;
  return duration_cast<nanoseconds>(system_clock::now().time_since_epoch()).count();
}

}  // namespace smaservo::page
