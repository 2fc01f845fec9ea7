#include "host-sim/fmu/export_fmu_command.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <memory>

#include "firmware/text/settings_file.hpp"
#include "host-sim/fmu/fmu_file.hpp"
#include "model/files/error.hpp"
#include "model/files/message.hpp"

namespace smaservo::fmu {
namespace {

struct ExportArguments {
  ExportOptions options;
  std::string kind{"wire"}, fmi{"3"};
  std::vector<std::string> settings;
};

void export_fmu(ExportArguments& a) {
  ExportOptions& o = a.options;
  o.kind = a.kind == "wire" ? Kind::wire : Kind::servo;
  o.version = a.fmi == "2" ? Version::fmi2 : Version::fmi3;
  o.overrides = text::parse_settings(a.settings);
  require("--load-N", o.load_N, 0, 1e4);
  if (o.kind == Kind::wire && !o.settings.empty()) {
    throw files::UserError("--settings: is of --kind servo; a wire has no settings");
  }
  if (o.wire.empty() && o.settings.empty()) {
    throw files::UserError("--wire: name a preset or a file; `host-sim wires` lists the presets");
  }
  if (!o.out.ends_with(".fmu")) {
    throw files::UserError(
        fmt::format("--out {}: must end in .fmu, since simulators know FMUs by it", o.out));
  }
  refuse_to_overwrite(o.wire, o.out);
  refuse_to_overwrite(o.settings, o.out);
  const Written written = write_fmu(describe(o), o.version, o.out);
  files::print(fmt::format(
      "{}: FMI {}, co-simulation, {}; {} inputs, {} outputs, {} parameters; {:.2f} MB\n", o.out,
      o.version == Version::fmi2 ? "2.0" : "3.0", identifier(o.kind), written.inputs,
      written.outputs, written.parameters, 1e-6 * static_cast<double>(written.bytes)));
  files::print(written.platforms.empty()
                   ? std::string("no library is inside, only sources: the simulator must build "
                                 "them\n")
                   : fmt::format("libraries for {}; sources for all others\n",
                                 fmt::join(written.platforms, ", ")));
}

}  // namespace

void add_export_fmu_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "export-fmu",
      "Writes a wire, or the servo on it, as an FMU for Simulink, OpenModelica and others.");
  auto a = std::make_shared<ExportArguments>();
  command->add_option(
      "--wire", a->options.wire,
      "preset or file that ends in .toml; with --settings: the wire that is driven, "
      "if the device's is another");
  command->add_option("--kind", a->kind, "wire: the wire alone (default); servo: device and wire")
      ->check(CLI::IsMember({"wire", "servo"}));
  command->add_option("--fmi", a->fmi, "version of FMI: 2 or 3 (default)")
      ->check(CLI::IsMember({"2", "3"}));
  command->add_option("--settings", a->options.settings,
                      "settings file of the device, for servo; default: settings for the wire");
  command->add_option("--set", a->settings, "key=value, of the wire or of the settings; repeatable")
      ->allow_extra_args(false);
  command->add_option("--load-N", a->options.load_N,
                      "load at the beginning; default: 100 MPa times the cross-section");
  command->add_option("--out", a->options.out, "the FMU; ends in .fmu")->required();
  command->callback([a] { export_fmu(*a); });
}

}  // namespace smaservo::fmu
