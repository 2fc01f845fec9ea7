#include "host-sim/report/gnuplot.hpp"

#include <cerrno>
#include <cmath>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <fstream>
#include <spawn.h>
#include <sstream>
#include <sys/wait.h>
#include <unistd.h>

#include "host-sim/report/panel.hpp"
#include "host-sim/temporary_folder.hpp"
#include "model/files/error.hpp"
#include "model/files/message.hpp"

namespace smaservo::report {
namespace {

namespace fs = std::filesystem;

std::string read_all(const fs::path& file) {
  const std::ifstream in(file, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

/// Runs gnuplot on a script and returns its output.
std::string gnuplot(const std::string& script) {
  const TemporaryFolder folder;
  const std::string script_file = (folder / "plot.gp").string();
  const std::string svg_file = (folder / "plot.svg").string();
  const std::string error_file = (folder / "plot.err").string();
  std::ofstream(script_file, std::ios::binary) << script;

  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  const int flags = O_WRONLY | O_CREAT | O_TRUNC;
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, svg_file.c_str(), flags, 0600);
  posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, error_file.c_str(), flags, 0600);
  std::string program = "gnuplot";
  std::string argument = script_file;
  char* const arguments[] = {program.data(), argument.data(), nullptr};
  pid_t child = 0;
  const int failed = posix_spawnp(&child, "gnuplot", &actions, nullptr, arguments, environ);
  posix_spawn_file_actions_destroy(&actions);
  if (failed != 0) {
    throw files::UserError(
        fmt::format("the report needs gnuplot (package gnuplot-nox): {}", std::strerror(failed)));
  }
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  std::string svg = read_all(svg_file);
  if (status != 0 || svg.find("</svg>") == std::string::npos) {
    throw files::UserError(fmt::format("gnuplot failed: {}", read_all(error_file)));
  }
  return svg;
}

constexpr const char* style = R"(set encoding utf8
set border 3 lc rgb '#666666'
set tics nomirror textcolor rgb '#333333'
set grid lc rgb '#dddddd' lw 0.5
set key outside top center horizontal
set style fill solid 1 noborder
)";

std::string colour_names() {
  std::string text;
  for (const Role& role : colours()) {
    text += fmt::format("{} = 0x{}\n", role.name, role.light.substr(1));
  }
  return text;
}

std::string drawn(const char* command, const Axes& axes, const std::string& data,
                  const std::string& more, const std::vector<std::string>& curves) {
  return gnuplot(
      fmt::format("set terminal svg size {},{} dynamic font 'sans-serif,13' lw 1.2\n{}{}"
                  "set xlabel {}\nset ylabel {}\n{}{}{} {}\n",
                  axes.width, axes.height, style, colour_names(), plotted_text(axes.x_label),
                  plotted_text(axes.y_label), more, data, command, fmt::join(curves, ", ")));
}

}  // namespace

std::string draw(const Axes& axes, const std::string& data, const std::string& more,
                 const std::vector<std::string>& curves) {
  return drawn("plot", axes, data, more, curves);
}

std::string draw_surface(const Axes& axes, const std::string& data, const std::string& more,
                         const std::vector<std::string>& surfaces) {
  return drawn("splot", axes, data, more, surfaces);
}

std::string plotted(double value) {
  return std::isfinite(value) ? fmt::format("{:.6g}", value) : "NaN";
}

std::string in_quotes(std::string_view text) {
  std::string all = "'";
  for (const char c : files::printable(text)) {
    all.append(c == '\'' ? "''" : std::string_view(&c, 1));
  }
  return all + "'";
}

std::string plotted_text(std::string_view text) {
  return in_quotes(text) + " noenhanced";
}

std::string plotted_row(std::span<const double> values) {
  std::string row;
  for (const double value : values) {
    row += (row.empty() ? "" : " ") + plotted(value);
  }
  return row + '\n';
}

}  // namespace smaservo::report
