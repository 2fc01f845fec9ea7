// Operations on parameters: write, try, store, and convert to and from a file.

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "firmware/text/canopen/objects.hpp"
#include "firmware/text/settings_file.hpp"
#include "firmware/text/settings_text.hpp"
#include "host-sim/can/settings.hpp"
#include "host-sim/page/servos/messages/tables.hpp"
#include "host-sim/page/servos/operations.hpp"
#include "model/files/error.hpp"
#include "model/files/message.hpp"

namespace smaservo::page {
namespace {

using files::UserError;
using nlohmann::json;

text::KnownObject object_at(std::size_t row) {
  return text::find_object(std::string(parameters<double>[row].path.text()));
}

std::vector<can::Change> changes_from(const std::vector<Operations::NewValue>& values) {
  std::vector<can::Change> changes;
  for (const auto& [row, value] : values) {
    const text::KnownObject object = object_at(row);
    changes.emplace_back(object, text::value_bytes(object, value));
  }
  return changes;
}

std::vector<can::Difference> differences_of(can::Remote remote, const std::string& toml) {
  const Settings<double> node = can::read_settings(remote);
  return can::differences(can::text_settings(toml, "the file", node), node);
}

}  // namespace

void Operations::write(Servo& servo, const std::vector<NewValue>& values) {
  can::Remote remote = this->remote(servo);
  const std::vector<can::Change> changes = changes_from(values);
  if (remote.number("tuning.state") != 0) {
    throw UserError(
        fmt::format("{}: a trial is going on; keep it or revert it first", servo.title()));
  }
  remote.change(changes);
}

void Operations::try_for(Servo& servo, const std::vector<NewValue>& values, double seconds) {
  can::Remote remote = this->remote(servo);
  const std::vector<can::Change> changes = changes_from(values);
  // A new trial replaces the one before.
  if (remote.number("tuning.state") != 0) {
    remote.revert_trial();
  }
  remote.try_for(changes, seconds);
  traffic_.refresh(servo.node);
}

void Operations::commit(Servo& servo) {
  remote(servo).keep_trial();
  traffic_.refresh(servo.node);
}

void Operations::revert(Servo& servo) {
  remote(servo).revert_trial();
  traffic_.refresh(servo.node);
}

void Operations::store(Servo& servo) {
  can::Remote remote = this->remote(servo);
  if (servo.is_enabled()) {
    throw UserError(fmt::format("{}: is enabled, and stores only while it is off: disable it first",
                                servo.title()));
  }
  // The shortened watch time-out belongs to the bridge and must not be stored.
  put_back_watch(servo);
  remote.store();
  skip_changes(servo);
  servo.unsaved = false;
  traffic_.refresh(servo.node);
}

std::string Operations::dump(Servo& servo, const std::string& as) {
  can::Remote remote = this->remote(servo);
  const Settings<double> settings = can::read_settings(remote);
  if (as == "toml") {
    return fmt::format("# Parameters of node {} on {}.\n\n", servo.node,
                       files::printable(bus_.name())) +
           text::to_toml(settings);
  }
  if (as != "can") {
    throw UserError(fmt::format("as = {}: must be toml or can", files::printable(as)));
  }
  // The quotes keep a shell from reading the brackets of an address as a pattern.
  std::string text = fmt::format("host-sim can --can '{}' --node {} set", bus_.name(), servo.node);
  for (const Parameter<double>& row : parameters<double>) {
    if (!row.is_used(settings) || row.path.text().starts_with("identity.")) {
      continue;
    }
    text += fmt::format(" \\\n  {}={}", row.path.text(), text::value_text(row, row.get(settings)));
  }
  return text + "\n";
}

json Operations::diff(Servo& servo, const std::string& toml) {
  return {{"differences", difference_messages(differences_of(remote(servo), toml))}};
}

json Operations::restore(Servo& servo, const std::string& toml) {
  can::Remote remote = this->remote(servo);
  const std::vector<can::Difference> all = differences_of(remote, toml);
  can::restore(remote, all);
  return {{"changed", difference_messages(all)}};
}

}  // namespace smaservo::page
