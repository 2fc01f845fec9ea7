#include <memory>

#include "host-sim/commands.hpp"
#include "host-sim/output_file.hpp"
#include "host-sim/scenario.hpp"
#include "host-sim/simulate.hpp"

namespace smaservo {

void add_simulate_command(CLI::App& app) {
  struct Arguments {
    std::string scenario;
    std::string out = "-";
  };
  CLI::App* command =
      app.add_subcommand("simulate", "Makes a trace with a plant that no observer knows.");
  auto a = std::make_shared<Arguments>();
  command->add_option("SCENARIO", a->scenario, "TOML file; host-sim/README.md has the keys")
      ->required();
  command->add_option("--out", a->out, "trace as CSV, - for standard output")
      ->capture_default_str();
  command->callback([a] {
    const Scenario scenario = load_scenario(a->scenario);
    OutputFile file(a->out);
    simulate(scenario, file);
    file.commit();
  });
}

}  // namespace smaservo
