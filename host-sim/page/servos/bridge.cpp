#include "host-sim/page/servos/bridge.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>
#include <thread>

#include "host-sim/page/servos/messages/tables.hpp"
#include "model/files/error.hpp"
#include "model/files/message.hpp"

namespace smaservo::page {
namespace {

using files::UserError;
using nlohmann::json;

constexpr std::int64_t retry_us = 1'000'000;
/// Time after which a missing servo has certainly ended its heat by its own watch, whose time-out
/// never exceeds --watch while this program heats.
std::int64_t longest_watch_us(const BridgePlan& plan) {
  return std::max<std::int64_t>(10'000'000,
                                2 * static_cast<std::int64_t>(plan.operations.watch_s * 1e6F));
}
constexpr std::int64_t recorder_poll_us = 50'000;
constexpr std::int64_t rest_us = 10'000;

}  // namespace

Bridge::Bridge(BridgePlan plan, std::unique_ptr<can::Bus> bus, std::unique_ptr<can::Bus> urgent)
    : plan_(std::move(plan)),
      port_(std::move(bus)),
      off_switch_(std::move(urgent)),
      stream_(plan_.sync_s, plan_.sync_signals),
      traffic_(*port_, plan_.traffic, stream_, control_, *this),
      bus_(*port_, traffic_),
      operations_(bus_, traffic_, control_, plan_.operations) {
  traffic_.set_busy(&bus_.busy());
  for (unsigned node = 1; node < 128; ++node) {
    off_switch_.knows_no_pdo(node);
    traffic_.probe(node);
  }
}

void Bridge::start(Sink& sink) {
  take_wall_clock(port_->now_us());
  sink_ = &sink;
}

// Switching off.

void Bridge::switch_off(const NodeSet& nodes, std::string_view why) {
  if (nodes.none()) {
    return;
  }
  if (!why.empty()) {
    for (unsigned node = 1; node < nodes.size(); ++node) {
      if (nodes[node]) {
        files::complain("host-sim", fmt::format("page: heat of node {} ended: {}", node, why));
      }
    }
  }
  off_switch_.off(nodes);
  {
    const std::scoped_lock lock(mutex_);
    to_check_ |= nodes;
  }
  bus_.interrupt();
}

void Bridge::client_left(std::uint32_t client) {
  switch_off(control_.give_up(client), fmt::format("client {}, who had control, is gone", client));
  const std::scoped_lock lock(mutex_);
  gone_clients_.insert(client);
}

/// Asks each servo that was switched off whether it is off, and repeats the command if it is not.
bool Bridge::check_off() {
  bus_.forget_interrupt();
  NodeSet nodes;
  {
    const std::scoped_lock lock(mutex_);
    nodes = to_check_;
  }
  const std::int64_t now_us = bus_.now_us();
  if (nodes.none() || (now_us < check_us_ && stops_.empty())) {
    return false;
  }
  check_us_ = now_us + retry_us;
  std::vector<std::string> hot;
  NodeSet done;
  for (unsigned node = 1; node < nodes.size(); ++node) {
    const auto found = nodes[node] ? traffic_.servos().find(node) : traffic_.servos().end();
    if (found == traffic_.servos().end()) {
      continue;
    }
    Servo& servo = found->second;
    // If two devices share the node-id, it is unknown which of them answers, but both have received
    // the frame that switches off. A servo that is away is switched off when it comes back, or
    // forgotten when its own watch must have ended the heat.
    if (servo.duplicate) {
      done.set(node);
      continue;
    }
    try {
      if (servo.online) {
        operations_.disable(servo);
        done.set(node);
      } else if (now_us - servo.left_us > longest_watch_us(plan_)) {
        done.set(node);
      } else {
        hot.push_back(servo.title());
      }
    } catch (const UserError& error) {
      hot.push_back(fmt::format("{} ({})", servo.title(), error.what()));
    }
  }
  if (!hot.empty()) {
    trouble(fmt::format("{}: does not confirm that it is off", fmt::join(hot, ", ")));
    off_switch_.off(nodes & ~done);
  }
  std::vector<std::pair<Reply, NodeSet>> answered;
  {
    const std::scoped_lock lock(mutex_);
    to_check_ &= ~done;
    answered.swap(stops_);
  }
  for (const auto& [reply, wanted] : answered) {
    const bool confirmed = hot.empty();
    reply({confirmed, confirmed ? "{}"
                                : fmt::format("{}: does not confirm that it is off; switch its "
                                              "supply off",
                                              fmt::join(hot, ", "))});
  }
  return true;
}

void Bridge::stop() {
  const NodeSet nodes = control_.stop_all();
  if (const std::optional<std::uint32_t> client = control_.client()) {
    control_.give_up(*client);
  }
  switch_off(nodes, "this program ends");
  bus_.forget_interrupt();
  try {
    const std::int64_t until_us = bus_.now_us() + 2'000'000;
    do {
      check_us_ = 0;
    } while (check_off() && bus_.now_us() < until_us);
    for (const unsigned node : stream_.mapped()) {
      can::Remote remote = operations_.remote(node);
      stream_.put_back(remote);
    }
    if (trial_) {
      operations_.revert(operations_.servo(trial_->first));
    }
  } catch (const std::exception& error) {
    files::complain("host-sim", error.what());
  }
  background_.finish();
  sink_ = nullptr;
}

// The bus's thread.

void Bridge::round() {
  try {
    apply_wishes();
    end_trial();
    run_next();
  } catch (const Interrupted&) {
    // A servo was switched off: the next round checks that.
    check_us_ = 0;
  } catch (const UserError& error) {
    trouble(error.what());
    publish_bridge(port_->now_us());
    rest();
  }
}

/// Waits after an error, because a bus that is off fails again at once.
void Bridge::rest() {
  try {
    hal::CanFrame frame;
    if (port_->receive(frame, port_->now_us() + rest_us)) {
      traffic_.heard(frame, port_->now_us());
    }
  } catch (const UserError&) {
    std::this_thread::sleep_for(std::chrono::microseconds(rest_us));
  }
}

void Bridge::run_next() {
  if (check_off() || run_job() || look_after_servos() || read_recording()) {
    return;
  }
  hal::CanFrame frame;
  const std::int64_t until_us = bus_.now_us() + 2000;
  while (bus_.receive(frame, until_us)) {
  }
}

bool Bridge::run_job() {
  std::optional<Job> job;
  {
    const std::scoped_lock lock(mutex_);
    if (jobs_.empty()) {
      return false;
    }
    job = std::move(jobs_.front());
    jobs_.pop_front();
  }
  bus_.forget_interrupt();
  try {
    if (job->ticket != 0 && !control_.holds(job->ticket)) {
      throw UserError("not done: control has passed on, or all was stopped");
    }
    const std::string answer = job->run();
    job->reply({true, answer});
  } catch (const Interrupted& interrupted) {
    job->reply({false, interrupted.what()});
  } catch (const std::exception& error) {
    job->reply({false, error.what()});
  }
  activity_.reset();
  published_us_ = 0;
  return true;
}

/// Ends a trial whose client has no control any more.
void Bridge::end_trial() {
  if (!trial_ || control_.client() == trial_->second) {
    return;
  }
  const unsigned node = trial_->first;
  trial_.reset();
  operations_.revert(operations_.servo(node));
}

bool Bridge::look_after_servos() {
  const std::int64_t now_us = bus_.now_us();
  for (auto& [node, servo] : traffic_.servos()) {
    if (!servo.online || servo.duplicate || now_us < next_try_us_[node]) {
      continue;
    }
    next_try_us_[node] = now_us + retry_us;
    try {
      if (look_after(servo, now_us)) {
        return true;
      }
    } catch (const UserError& error) {
      trouble(fmt::format("{}: {}", servo.title(), error.what()));
      return true;
    }
    next_try_us_[node] = now_us;
  }
  return false;
}

/// Returns whether there was something to do.
bool Bridge::look_after(Servo& servo, std::int64_t now_us) {
  const unsigned node = servo.node;
  if (!servo.joined) {
    if (!operations_.join(servo)) {
      traffic_.servos().erase(node);
      return true;
    }
    show(servo);
    tell_parameters(node, {});
    published_us_ = 0;
    return true;
  }
  // An axis that has ended its heat by itself gets its usual watch time-out back.
  if (servo.usual_timeout_s && !control_.heated()[node] && !activity_) {
    operations_.put_back_watch(servo);
    return true;
  }
  const auto counted = servo.values.find({0x2220, 1});
  if (counted != servo.values.end() && counted->second != servo.changes_seen) {
    const std::vector<std::size_t> rows = operations_.read_changes(servo);
    counted->second = servo.changes_seen.value_or(0);
    if (!rows.empty()) {
      tell_parameters(node, rows);
    }
    return true;
  }
  if (look_after_stream(servo)) {
    return true;
  }
  next_try_us_[node] = now_us;
  return false;
}

/// Makes a servo send by SYNC while its live values are wanted.
bool Bridge::look_after_stream(Servo& servo) {
  const auto until = live_until_us_.find(servo.node);
  const bool wanted =
      stream_.wanted() && until != live_until_us_.end() && bus_.now_us() < until->second;
  if (wanted == stream_.is_mapped(servo.node)) {
    return false;
  }
  can::Remote remote = operations_.remote(servo);
  operations_.read_changes(servo);
  if (wanted) {
    stream_.map(remote);
  } else {
    stream_.put_back(remote);
  }
  // The log now contains the bridge's own changes, which must not be reported.
  operations_.skip_changes(servo);
  return true;
}

bool Bridge::read_recording() {
  if (recorded_.empty()) {
    const std::scoped_lock lock(mutex_);
    gone_clients_.clear();
    return false;
  }
  const std::int64_t now_us = bus_.now_us();
  for (auto it = recorded_.begin(); it != recorded_.end(); ++it) {
    Recorded& running = *it;
    if (now_us < running.next_us) {
      continue;
    }
    running.next_us = now_us + recorder_poll_us;
    bool gone = false;
    {
      const std::scoped_lock lock(mutex_);
      gone = gone_clients_.contains(running.client);
    }
    try {
      operations_.servo(running.recording.node());
      if (gone) {
        running.recording.stop();
      } else if (const can::RecorderStage before = running.recording.stage();
                 running.recording.look() != can::RecorderStage::complete) {
        if (running.recording.stage() != before) {
          published_us_ = 0;
        }
        continue;
      } else {
        running.reply({true, json_text({{"recording", recordings_.kept(running.recording.read(),
                                                                       json::object())}})});
      }
    } catch (const UserError& error) {
      running.reply({false, error.what()});
    }
    recorded_.erase(it);
    published_us_ = 0;
    return true;
  }
  return false;
}

}  // namespace smaservo::page
