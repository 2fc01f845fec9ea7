#include "host-sim/can/settings.hpp"

#include <fmt/format.h>

#include "firmware/text/settings_file.hpp"
#include "host-sim/can/shown.hpp"
#include "model/files/error.hpp"
#include "model/files/text_table.hpp"
#include "model/files/toml/toml_fields.hpp"

namespace smaservo::can {
namespace {

Value value_of(const Bytes& bytes) {
  return {static_cast<std::uint32_t>(canopen::take_number(bytes))};
}

text::KnownObject object_of(const Parameter<double>& row) {
  return text::find_object(std::string(row.path.text()));
}

}  // namespace

Settings<double> read_settings(Remote& remote) {
  Settings<double> settings = default_settings<double>();
  for (const Parameter<double>& row : parameters<double>) {
    row.set(settings, value_of(remote.read(object_of(row))));
  }
  for (const Parameter<double>& row : parameters<double>) {
    if (row.is_used(settings) && fit(row, row.get(settings)) == Fit::not_finite) {
      throw files::UserError(
          fmt::format("node {}: {} is not set: it has no wire yet; give it a whole "
                      "settings file with `host-sim can restore`",
                      remote.node(), row.path.text()));
    }
  }
  return stored_settings<double>(settings);
}

Settings<double> file_settings(const std::string& path, const Settings<double>& of_node) {
  Settings<double> settings = text::load_settings_file(path);
  settings.identity = of_node.identity;
  return settings;
}

Settings<double> text_settings(const std::string& toml, const std::string& origin,
                               const Settings<double>& of_node) {
  const toml::table table = files::parse_toml(toml, origin);
  for (const auto& name :
       {table["wire"].value<std::string>(), table["wire"]["based_on"].value<std::string>()}) {
    if (name && name->ends_with(".toml")) {
      throw files::ConfigError(fmt::format(
          "{}: wire {}: must be a preset or the whole wire, not a file", origin, *name));
    }
  }
  Settings<double> settings = text::parse_settings_file(toml, origin);
  settings.identity = of_node.identity;
  return settings;
}

std::vector<Difference> differences(const Settings<double>& file, const Settings<double>& node) {
  std::vector<Difference> all;
  for (const Parameter<double>& row : parameters<double>) {
    const Value here = row.get(file);
    const Value there = row.get(node);
    if (row.is_used(file) && here != there) {
      all.push_back({&row, here, there});
    }
  }
  return all;
}

std::string differences_text(const std::vector<Difference>& differences, Units units) {
  files::TextTable table({{""}, {""}, {""}});
  for (const Difference& d : differences) {
    const text::KnownObject object = parameter_in(std::string(d.row->path.text()), units);
    table.add({object.name, text::value_text(object, bytes_of(object, d.here)),
               text::value_text(object, bytes_of(object, d.there))});
  }
  return table.text();
}

Bytes bytes_of(const text::KnownObject& object, Value value) {
  Bytes bytes(canopen::size_of(object.type));
  canopen::put_number(bytes, value.bits);
  return bytes;
}

void restore(Remote& remote, const std::vector<Difference>& differences) {
  std::vector<Change> changes;
  for (const Difference& d : differences) {
    const text::KnownObject object = object_of(*d.row);
    changes.emplace_back(object, bytes_of(object, d.here));
  }
  remote.change(changes);
}

}  // namespace smaservo::can
