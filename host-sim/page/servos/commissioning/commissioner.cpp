#include "host-sim/page/servos/commissioning/commissioner.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <thread>
#include <utility>

#include "host-sim/can/settings.hpp"
#include "host-sim/commission/fitted_run.hpp"
#include "host-sim/page/servos/messages/exports.hpp"
#include "host-sim/page/servos/messages/tables.hpp"
#include "model/files/error.hpp"
#include "model/files/input_file.hpp"
#include "model/files/message.hpp"

namespace smaservo::page {
namespace {

using files::UserError;
using nlohmann::json;

/// Lines of a run that stay in sight.
constexpr std::size_t most_said = 8;
constexpr std::size_t longest_answer = 40;
constexpr const char* wire_name = "wire.toml";

/// A message without the folder of this machine, in which the run is for a short while.
std::string without(const std::string& folder, std::string text) {
  for (std::size_t at = text.find(folder); at != std::string::npos; at = text.find(folder)) {
    text.erase(at, folder.size());
  }
  return text;
}

}  // namespace

const char* Commissioner::name_of(Stage stage) {
  constexpr std::array names{"none",    "waiting", "checking", "asking",
                             "heating", "fitting", "done",     "failed"};
  return names.at(static_cast<std::size_t>(stage));
}

bool Commissioner::is_busy_now() const {
  return stage_ != Stage::none && stage_ != Stage::done && stage_ != Stage::failed;
}

bool Commissioner::is_busy() const {
  const std::scoped_lock lock(mutex_);
  return is_busy_now();
}

void Commissioner::change_to(Stage stage) {
  stage_ = stage;
  changed_ = true;
}

bool Commissioner::has_changed() {
  const std::scoped_lock lock(mutex_);
  return std::exchange(changed_, false);
}

void Commissioner::begin(std::uint32_t client, const CommissionTask& task) {
  const std::scoped_lock lock(mutex_);
  if (is_busy_now()) {
    throw UserError(
        fmt::format("node {} is being commissioned for client {}", task_.node, client_));
  }
  client_ = client;
  task_ = task;
  cancelled_ = false;
  line_.clear();
  error_.clear();
  said_.clear();
  share_ = 0;
  result_ = nullptr;
  files_ = {};
  change_to(Stage::waiting);
}

std::optional<unsigned> Commissioner::node_on_bus() const {
  const std::scoped_lock lock(mutex_);
  return is_busy_now() && stage_ != Stage::fitting ? std::optional(task_.node) : std::nullopt;
}

void Commissioner::failed(std::string_view why) {
  std::unique_lock lock(mutex_);
  error_ = why;
  change_to(Stage::failed);
  end_question(lock);
}

// The run.

Commissioner::Heated Commissioner::heat(can::Remote remote, const std::function<void()>& looks) {
  CommissionTask task;
  {
    const std::scoped_lock lock(mutex_);
    if (cancelled_) {
      throw UserError("cancelled before the heat");
    }
    task = task_;
    change_to(Stage::checking);
  }
  looks_ = looks;
  looks_();
  Heated heated{can::read_settings(remote), std::make_unique<TemporaryFolder>(), {}};
  const std::string name = fmt::format("commission-node{}.csv", task.node);
  commission::LiveOptions options;
  options.node = task.node;
  options.path = *heated.folder / name.c_str();
  options.questions = task.readings > 0;
  options.asks = task.readings;
  options.reading_sd_m = task.reading_sd_m;
  options.times = commission::LevelTimes{}.times(task.pace);
  heated.run = commission::record_live(options, remote, *this);
  if (heated.run.anchors.size() == 1) {
    heated.run.anchors.clear();
    heated.run.notes.emplace_back("a single reading tells nothing, and is not used");
  }
  std::string rows = files::whole_file(heated.run.path);
  std::unique_lock lock(mutex_);
  files_.run = std::move(rows);
  files_.run_name = name;
  if (!heated.run.anchors.empty()) {
    files_.readings = commission::anchors_csv(heated.run.anchors);
    files_.readings_name = fmt::format("commission-node{}-readings.csv", task.node);
  }
  line_.clear();
  change_to(Stage::fitting);
  end_question(lock);
  return heated;
}

void Commissioner::show(std::string_view line) {
  {
    std::unique_lock lock(mutex_);
    line_ = line;
    change_to(Stage::heating);
    end_question(lock);
  }
  looks_();
}

void Commissioner::say(std::string_view line) {
  std::unique_lock lock(mutex_);
  said_.emplace_back(line);
  if (said_.size() > most_said) {
    said_.pop_front();
  }
  // Whoever does not answer in time is told so.
  change_to(stage_ == Stage::asking ? Stage::heating : stage_);
  end_question(lock);
}

void Commissioner::ask(std::string_view /*question*/, std::int64_t until_us) {
  const std::scoped_lock lock(mutex_);
  until_us_ = until_us;
  change_to(Stage::asking);
}

std::optional<std::string> Commissioner::typed() {
  looks_();
  const std::scoped_lock lock(mutex_);
  if (!pending_ || pending_->handed) {
    return {};
  }
  pending_->handed = true;
  return pending_->typed;
}

void Commissioner::answered(std::string_view objection) {
  std::optional<Pending> answered;
  {
    const std::scoped_lock lock(mutex_);
    answered.swap(pending_);
    if (objection.empty()) {
      line_.clear();
      change_to(Stage::heating);
    }
  }
  if (answered) {
    answered->reply({objection.empty(), objection.empty() ? "{}" : std::string(objection)});
  }
}

/// An answer that came too late.
void Commissioner::end_question(std::unique_lock<std::mutex>& lock) {
  std::optional<Pending> late;
  late.swap(pending_);
  lock.unlock();
  if (late) {
    late->reply({false, "too late: the wire is not held any more for this reading"});
  }
}

// The fit.

json Commissioner::result_of(const Heated& heated, const std::function<bool()>& goes_on) {
  commission::CommissionOptions options;
  // One core is left for the bus.
  options.threads = std::max(1, static_cast<int>(std::thread::hardware_concurrency()) - 1);
  options.proceed = [&](double share) {
    const std::scoped_lock lock(mutex_);
    share_ = share;
    changed_ = true;
    return !cancelled_ && goes_on();
  };
  std::string name;
  unsigned node = 0;
  {
    const std::scoped_lock lock(mutex_);
    name = files_.run_name;
    node = task_.node;
  }
  const identify::Run recorded = commission::heated_run(
      heated.run.path,
      {.geometry = heated.settings.wire.geometry, .stress_Pa = {}, .load_N = {}, .trace = {}});
  const commission::Commissioning all = commission::fitted_run(
      {fmt::format("the settings of node {}", node), heated.settings.wire, {}}, recorded,
      heated.run.anchors, options, name, wire_name);
  const files::WireDescription wire = commission::commissioned_wire(all, "wire");
  Settings<double> fitted = heated.settings;
  fitted.wire = wire.wire;
  const json result{
      {"text", commission::text(all)},
      {"numbers", json::parse(commission::json(all))},
      {"notes", heated.run.notes},
      {"differences", difference_messages(can::differences(fitted, heated.settings))}};
  const std::scoped_lock lock(mutex_);
  files_.wire = files::to_toml(wire);
  return result;
}

void Commissioner::fit(const Heated& heated, const std::function<bool()>& goes_on) {
  const std::string folder = heated.run.path.substr(0, heated.run.path.rfind('/') + 1);
  try {
    json result = result_of(heated, goes_on);
    const std::scoped_lock lock(mutex_);
    result_ = std::move(result);
    change_to(Stage::done);
  } catch (const std::exception& error) {
    throw UserError(without(folder, error.what()));
  }
}

// What clients ask.

void Commissioner::answer(std::uint32_t client, const json& request,
                          std::function<void(Answer)> reply) {
  std::string typed;
  if (request.contains("reading")) {
    typed = text_in(request, "reading");
    if (typed.size() > longest_answer) {
      throw UserError(fmt::format("reading: must have at most {} characters", longest_answer));
    }
    if (typed.find_first_not_of(" \t\r\n") == std::string::npos) {
      throw UserError("reading: must be a length in mm, such as 3.4; without it none is taken");
    }
  }
  const std::scoped_lock lock(mutex_);
  if (stage_ != Stage::asking) {
    throw UserError("no reading is asked for now");
  }
  if (client != client_) {
    throw UserError(fmt::format("client {} leads this run, and is asked", client_));
  }
  if (pending_) {
    throw UserError("the answer before is being looked at");
  }
  pending_ = Pending{std::move(typed), std::move(reply)};
}

std::optional<unsigned> Commissioner::cancel(std::uint32_t client) {
  const std::scoped_lock lock(mutex_);
  if (!is_busy_now()) {
    throw UserError("no wire is being commissioned");
  }
  if (client != client_) {
    throw UserError(fmt::format("client {} leads this run; `stop` ends it as well", client_));
  }
  cancelled_ = true;
  const bool heats = stage_ != Stage::waiting && stage_ != Stage::fitting;
  return heats ? std::optional(task_.node) : std::nullopt;
}

void Commissioner::ends(unsigned node) {
  const std::scoped_lock lock(mutex_);
  cancelled_ = cancelled_ || (is_busy_now() && task_.node == node && stage_ != Stage::fitting);
}

bool Commissioner::is_cancelled() const {
  const std::scoped_lock lock(mutex_);
  return cancelled_;
}

json Commissioner::file(const json& request) const {
  const std::string as = text_in(request, "as");
  const std::scoped_lock lock(mutex_);
  const std::pair<const std::string*, std::string> found =
      as == "wire"       ? std::pair(&files_.wire, std::string(wire_name))
      : as == "run"      ? std::pair(&files_.run, files_.run_name)
      : as == "readings" ? std::pair(&files_.readings, files_.readings_name)
                         : std::pair<const std::string*, std::string>(nullptr, "");
  if (found.first == nullptr) {
    throw UserError(fmt::format("as = {}: must be wire, run or readings", files::printable(as)));
  }
  if (found.first->empty()) {
    throw UserError(fmt::format("as = {}: the last run has none, or there was no run", as));
  }
  return {{"name", found.second}, {"base64", base64(*found.first)}};
}

std::string Commissioner::message(std::int64_t now_us) const {
  const std::scoped_lock lock(mutex_);
  const bool none = stage_ == Stage::none;
  json message{{"node", none ? json() : json(task_.node)},
               {"client", none ? json() : json(client_)},
               {"stage", name_of(stage_)},
               {"line", line_},
               {"said", said_},
               {"left_s", nullptr},
               {"share", std::round(100 * share_) / 100},
               {"error", error_},
               {"result", result_}};
  if (stage_ == Stage::asking) {
    message["left_s"] =
        std::max(0.0, std::round(1e-5 * static_cast<double>(until_us_ - now_us)) / 10);
  }
  message["files"] = json::array();
  for (const auto& [name, text] : {std::pair("wire", &files_.wire), std::pair("run", &files_.run),
                                   std::pair("readings", &files_.readings)}) {
    if (!text->empty()) {
      message["files"].push_back(name);
    }
  }
  return json_text(message);
}

}  // namespace smaservo::page
