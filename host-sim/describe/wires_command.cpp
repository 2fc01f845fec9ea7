#include <fmt/format.h>
#include <memory>

#include "firmware/text/settings_file.hpp"
#include "host-sim/describe/describe_command.hpp"
#include "model/files/message.hpp"
#include "model/wire/plant.hpp"

namespace smaservo::describe {
namespace {

void list_presets() {
  files::print(fmt::format("{:<18}{:>12}{:>10}{:>10}{:>12}\n", "preset", "diameter", "Ω/m", "limit",
                           "load"));
  for (const std::string& name : files::preset_names()) {
    const Wire<double> w = files::load_wire(name).wire;
    files::print(fmt::format("{:<18}{:>9.0f} µm{:>9.4g}{:>8.0f} mA{:>10.3g} N\n", name,
                             1e6 * w.geometry.diameter_m,
                             cold_resistance_ohm(w) / w.geometry.length_m, 1e3 * w.limits.current_A,
                             w.limits.stress_Pa * w.geometry.area_m2()));
  }
}

}  // namespace

void add_wires_command(CLI::App& app) {
  struct WiresArguments {
    std::string name;
    std::vector<std::string> settings;
  };
  CLI::App* command = app.add_subcommand(
      "wires", "Lists the wires that are built in, or prints one with all its parameters.");
  auto a = std::make_shared<WiresArguments>();
  command->add_option("WIRE", a->name, "preset or file that ends in .toml");
  command->add_option("--set", a->settings, "key=value; repeatable")->allow_extra_args(false);
  command->callback([a] {
    if (a->name.empty()) {
      list_presets();
    } else {
      files::print(files::to_toml(files::load_wire(a->name, text::parse_settings(a->settings))));
    }
  });
}

}  // namespace smaservo::describe
