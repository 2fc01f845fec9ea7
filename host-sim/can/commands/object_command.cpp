#include <algorithm>
#include <fmt/format.h>
#include <memory>
#include <utility>

#include "firmware/text/settings_file.hpp"
#include "firmware/text/settings_text.hpp"
#include "host-sim/can/commands/session.hpp"
#include "host-sim/can/outcome.hpp"
#include "host-sim/can/settings.hpp"
#include "host-sim/can/shown.hpp"
#include "model/files/error.hpp"
#include "model/files/message.hpp"
#include "model/files/output_file.hpp"

namespace smaservo::can {
namespace {

void get(Remote& remote, const std::vector<std::string>& names, Units units) {
  for (const std::string& name : names) {
    const can::Shown shown = can::shown_object(name, units);
    const std::optional<Kind> mode = shown.by_mode ? can::kind_in_force(remote) : std::nullopt;
    can::require_in_force(shown, mode);
    const text::KnownObject object = can::in_force(shown, mode, units);
    const std::string value = text::value_text(object, remote.read(object));
    const bool alone = names.size() == 1 && shown.names_unit;
    files::print(files::printable(alone ? value : object.name + " = " + value) + "\n");
    if (shown.by_mode && !mode) {
      files::print(fmt::format("{}: {}\n", object.name, can::unknown_mode), stderr);
    }
  }
}

std::string no_value(const std::string& name) {
  return fmt::format("{}: has no value; must be NAME VALUE or NAME=VALUE", name);
}

/// The change of an object to a value that may have a unit behind it; the object is then in this
/// unit.
can::Change change_of(const std::string& name, const std::string& value) {
  bool unitless = false;
  text::KnownObject object = text::find_quantity(name, unitless);
  if (value.empty() && object.type != canopen::Type::text) {
    throw files::UserError(no_value(name));
  }
  if (!object.writable) {
    throw files::UserError(fmt::format("{} cannot be written", text::title(object)));
  }
  const std::optional<text::Quantity> quantity =
      object.kind.empty() ? std::nullopt : text::quantity_of(value);
  if (quantity && quantity->unit.empty() && unitless) {
    throw files::UserError(
        fmt::format("{} = {}: needs a unit, in the name or behind the number: {}", name, value,
                    text::suffixes_text(object.kind)));
  }
  const can::Bytes bytes = text::value_bytes(object, value);
  const std::optional<Unit> unit =
      quantity ? quantity->unit_in(object.kind, object.unit) : std::nullopt;
  if (unit) {
    object = text::in_unit(object, *unit);
  }
  return {object, bytes};
}

std::vector<can::Change> changes_of(const std::vector<std::string>& texts) {
  std::vector<can::Change> changes;
  if (texts.size() == 2 && texts[0].find('=') == std::string::npos) {
    return {change_of(texts[0], texts[1])};
  }
  changes.reserve(texts.size());
  for (const std::string& text : texts) {
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos) {
      throw files::UserError(no_value(text));
    }
    if (equals == 0) {
      throw files::UserError(
          fmt::format("{}: has no name; must be NAME VALUE or NAME=VALUE", text));
    }
    can::Change change = change_of(text.substr(0, equals), text.substr(equals + 1));
    const Key key = change.first.key;
    const bool given = std::ranges::any_of(
        changes, [&](const can::Change& other) { return other.first.key == key; });
    // Other objects may need several values, one after the other, as the controlword.
    if (given && change.first.parameter != nullptr) {
      throw files::UserError(fmt::format("{}: given twice", change.first.parameter->path.text()));
    }
    changes.push_back(std::move(change));
  }
  return changes;
}

void change(Remote& remote, const std::vector<can::Change>& changes, const Common& common) {
  const std::vector<can::Bytes> before =
      common.quiet ? std::vector<can::Bytes>() : can::values_before(remote, changes);
  remote.change(changes);
  say(common, [&] { return can::changed_text(changes, before); });
}

void dump(Remote& remote, const std::string& out, const Common& /*common*/) {
  files::OutputFile file(out);
  file.write(fmt::format("# Parameters of node {} on {}.\n\n", remote.node(),
                         files::printable(remote.bus().name())));
  file.write(text::to_toml(can::read_settings(remote)));
  file.commit();
}

std::vector<can::Difference> differences(Remote& remote, const std::string& path) {
  const Settings<double> node = can::read_settings(remote);
  return can::differences(can::file_settings(path, node), node);
}

void restore(Remote& remote, const std::string& path, const Common& common) {
  const auto all = differences(remote, path);
  can::restore(remote, all);
  say(common, [&] { return can::restored_text(all, common.units); });
  print(fmt::format("{} parameter{} changed\n", all.size(), all.size() == 1 ? "" : "s"));
}

void diff(Remote& remote, const std::string& path, const Common& common) {
  const auto all = differences(remote, path);
  print(can::differences_text(all, common.units));
  // As with diff(1), the exit status 1 means that there are differences.
  if (!all.empty()) {
    throw CLI::RuntimeError(1);
  }
}

void add_trial_commands(CLI::App& can, const std::shared_ptr<Common>& common) {
  auto values = std::make_shared<std::vector<std::string>>();
  auto for_s = std::make_shared<double>(30);
  CLI::App* attempt = add(
      can, "try", "Puts parameters in force together, for a time: then they are as before.", [=] {
        const std::vector<can::Change> changes = changes_of(*values);
        Session session(*common);
        std::string said = can::begin_trial(session.remote(), changes, *for_s);
        say(*common, [&] { return said; });
      });
  attempt->add_option("NAME VALUE | NAME=VALUE", *values, "as for `set`; parameters only")
      ->required();
  attempt->add_option("--for", *for_s, "duration of the trial, s")
      ->capture_default_str()
      ->check(seconds_of(0.1, 3600));
  add_plain(can, common, "keep",
            "Makes the trial's values stay; `store` saves them for the next start.",
            [](Remote& remote, const Common& c) {
              std::string said = can::keep_trial(remote);
              say(c, [&] { return said; });
            });
  add_plain(can, common, "revert", "Takes back at once what is on trial.",
            [](Remote& remote, const Common& c) {
              std::string said = can::revert_trial(remote);
              say(c, [&] { return said; });
            });
}

}  // namespace

void add_object_commands(CLI::App& can, const std::shared_ptr<Common>& common) {
  auto names = std::make_shared<std::vector<std::string>>();
  add(can, "get", "Reads objects: parameters and live values by name, others by INDEX:SUB.",
      [=] {
        Session session(*common);
        get(session.remote(), *names, common->units);
      })
      ->add_option(
          "NAME", *names,
          "with its unit, for the number alone: strain.proportional_W, wire_temperature_degC; "
          "without, for name, unit and number in that of --units: wire_temperature; 6041")
      ->required();
  auto values = std::make_shared<std::vector<std::string>>();
  add(can, "set", "Writes objects; several parameters take effect together, or none does.",
      [=] {
        const std::vector<can::Change> changes = changes_of(*values);
        Session session(*common);
        change(session.remote(), changes, *common);
      })
      ->add_option("NAME VALUE | NAME=VALUE", *values,
                   "an object and its value in any unit of its kind: strain.proportional_W 0.5, "
                   "limits.temperature=120degC")
      ->required();
  add_trial_commands(can, common);
  const auto with_file = [&](const char* command, const char* meaning, const char* option,
                             void (*run)(Remote&, const std::string&, const Common&)) {
    auto file = std::make_shared<std::string>();
    add(can, command, meaning,
        [=] {
          Session session(*common);
          run(session.remote(), *file, *common);
        })
        ->add_option(option, *file, "TOML, as `host-sim describe settings` gives it")
        ->required();
  };
  with_file("dump", "Writes all parameters to a settings file; - is standard output.", "FILE",
            dump);
  with_file("restore", "Writes the parameters that differ from a settings file, as one set.",
            "FILE", restore);
  with_file("diff",
            "Compares a settings file (left) with the node (right); status 1 if they differ.",
            "FILE", diff);
  add_plain(can, common, "store",
            "Stores parameters and communication settings over a reset (1010h).",
            [](Remote& remote, const Common& c) {
              remote.store();
              say(c, can::stored_text);
            });
}

}  // namespace smaservo::can
