#include "host-sim/papers/figures/figures_command.hpp"

#include <fmt/format.h>
#include <memory>

#include "host-sim/papers/figures/figure.hpp"
#include "model/files/message.hpp"

namespace smaservo::figures {

void add_figures_command(CLI::App& app) {
  struct FiguresArguments {
    std::string out = "figures";
    std::vector<std::string> papers;
  };
  CLI::App* command = app.add_subcommand(
      "figures", "Draws the figures of the four papers again, from the project's models.");
  auto a = std::make_shared<FiguresArguments>();
  command->add_option("--out", a->out, "folder for the pictures and index.html")
      ->capture_default_str();
  command->add_option("--paper", a->papers, "000 to 003; default: all; repeatable")
      ->allow_extra_args(false);
  command->callback([a] {
    write_figures(a->out, a->papers);
    files::print(files::printable(a->out + "/index.html") + "\n");
  });
}

}  // namespace smaservo::figures
