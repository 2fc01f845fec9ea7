#include "firmware/bench/scenario/command_program.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <numbers>
#include <optional>
#include <utility>

#include "firmware/bench/scenario/scenario_tables.hpp"
#include "model/units.hpp"

namespace smaservo::bench {
namespace {

constexpr double min_lasting_s = 1e-3;

constexpr auto power_units = std::to_array<Unit>({{"W", 1}, {"mW", 1e-3}});

/// A mode with a set-point: the name of its key and the range of the set-point in SI.
struct Quantity {
  std::string_view name;
  Kind kind;
  Mode mode;
  double low, high;
};
constexpr std::array quantities{
    Quantity{"current", smaservo::kind::current, Mode::current, 0, 100},
    Quantity{"power", power_units, Mode::power, 0, 1000},
    Quantity{"resistance", smaservo::kind::resistance, Mode::resistance, 0, 1e5},
    Quantity{"temperature", smaservo::kind::temperature, Mode::temperature, 200, 800},
    Quantity{"strain", smaservo::kind::number, Mode::strain, -0.05, 0.2},
    Quantity{"position", smaservo::kind::length, Mode::position, -1, 1},
    Quantity{"force", smaservo::kind::force, Mode::force, 0, 1e4}};

enum class Shape : unsigned char { hold, staircase, sine, trapezoid, random };
constexpr std::array<std::string_view, 5> shape_names{"hold", "staircase", "sine", "trapezoid",
                                                      "random"};
/// Modes without a set-point.
constexpr std::array<std::string_view, 2> bare_modes{"off", "identification"};

struct Setpoint {
  Mode mode;
  double first, second;  ///< in SI; equal where the file has one number
};

std::vector<std::string> all_keys() {
  std::vector<std::string> keys;
  for (const Quantity& quantity : quantities) {
    for (const Unit& unit : quantity.kind) {
      keys.push_back(unit.suffix.empty() ? std::string(quantity.name)
                                         : fmt::format("{}_{}", quantity.name, unit.suffix));
    }
  }
  return keys;
}

Setpoint read_setpoint(files::TomlTable& table) {
  std::optional<Setpoint> found;
  if (table.has("mode")) {
    found = {table.choice("mode", bare_modes) == 0 ? Mode::off : Mode::identification, 0, 0};
  }
  for (const std::string& key : all_keys()) {
    if (!table.has(key)) {
      continue;
    }
    if (found) {
      table.fail(key, "must not be given beside another set-point or mode in the same table");
    }
    for (const Quantity& quantity : quantities) {
      const auto unit = unit_of(key, quantity.name, quantity.kind);
      if (!unit) {
        continue;
      }
      const double low = unit->from_si(quantity.low);
      const double high = unit->from_si(quantity.high);
      if (table.is_list(key)) {
        const std::vector<double> both = table.numbers(key, low, high);
        if (both.size() != 2) {
          table.fail(key, "must be one number, or two: [from, to]");
        }
        found = {quantity.mode, unit->to_si(both[0]), unit->to_si(both[1])};
      } else {
        const double value = unit->to_si(table.number(key, low, high));
        found = {quantity.mode, value, value};
      }
    }
  }
  if (!found) {
    table.fail("mode", fmt::format("is missing; give it or one set-point: {}",
                                   fmt::join(all_keys(), ", ")));
  }
  return *found;
}

CommandStretch read_common(files::TomlTable& table, Mode mode) {
  CommandStretch stretch{};
  stretch.command.mode = mode;
  stretch.command.arm = table.flag("arm", mode != Mode::off);
  stretch.command.clear_faults = table.flag("clear_faults", false);
  stretch.silent = table.flag("silent", false);
  if (table.has("scale")) {
    const std::vector<double> scale = table.numbers("scale", 0, 100);
    if (scale.size() != 3) {
      table.fail("scale", "must be three numbers: [proportional, integral, derivative]");
    }
    stretch.command.scale = {scale[0], scale[1], scale[2]};
  }
  return stretch;
}

/// Makes the stretches of one [[command]] table.
class Maker {
 public:
  Maker(files::TomlTable& table, std::mt19937_64& random, std::vector<CommandStretch>& to)
      : table_(table),
        random_(random),
        to_(to),
        setpoint_(read_setpoint(table)),
        common_(read_common(table, setpoint_.mode)) {}

  void make() {
    const auto shape =
        table_.has("shape") ? static_cast<Shape>(table_.choice("shape", shape_names)) : Shape::hold;
    switch (shape) {
      case Shape::hold:
        line(setpoint_.first, setpoint_.second, table_.number("for_s", min_lasting_s, longest_s));
        break;
      case Shape::staircase:
        staircase();
        break;
      case Shape::sine:
        sine();
        break;
      case Shape::trapezoid:
        trapezoid();
        break;
      case Shape::random:
        random_steps();
        break;
    }
  }

 private:
  void line(double from, double to, double seconds) {
    CommandStretch stretch = common_;
    stretch.command.setpoint = from;
    stretch.end = to;
    stretch.seconds = seconds;
    to_.push_back(stretch);
  }
  double between(double share) const {
    return setpoint_.first + share * (setpoint_.second - setpoint_.first);
  }

  /// Goes up in steps and down again.
  void staircase() {
    const int steps = static_cast<int>(table_.number("steps", 1, 1000));
    const double each_s = table_.number("each_s", min_lasting_s, longest_s);
    for (int i = 0; i <= 2 * steps; ++i) {
      const double level = between(static_cast<double>(i <= steps ? i : 2 * steps - i) / steps);
      line(level, level, each_s);
    }
  }

  void sine() {
    CommandStretch stretch = common_;
    stretch.command.setpoint = stretch.end = between(0.5);
    stretch.amplitude = 0.5 * (setpoint_.second - setpoint_.first);
    if (table_.is_list("Hz")) {
      std::tie(stretch.from_Hz, stretch.to_Hz) = table_.range("Hz", 1e-3, 100);
    } else {
      stretch.from_Hz = stretch.to_Hz = table_.number("Hz", 1e-3, 100);
    }
    stretch.seconds = table_.number("for_s", min_lasting_s, longest_s);
    to_.push_back(stretch);
  }

  void trapezoid() {
    const double ramp_s = table_.number("ramp_s", min_lasting_s, longest_s);
    const double hold_s = table_.number("hold_s", min_lasting_s, longest_s);
    const double times = std::round(table_.number("times", 1, 1e4, 1));
    for (double i = 0; i < times; ++i) {
      line(setpoint_.first, setpoint_.second, ramp_s);
      line(setpoint_.second, setpoint_.second, hold_s);
      line(setpoint_.second, setpoint_.first, ramp_s);
      line(setpoint_.first, setpoint_.first, hold_s);
    }
  }

  void random_steps() {
    const auto [min_s, max_s] = table_.range("each_s", min_lasting_s, longest_s);
    double left_s = table_.number("for_s", min_lasting_s, longest_s);
    std::uniform_real_distribution<double> seconds(min_s, max_s);
    std::uniform_real_distribution<double> share(0, 1);
    while (left_s > 0) {
      const double part_s = std::min(seconds(random_), left_s);
      const double level = between(share(random_));
      line(level, level, part_s);
      left_s -= part_s;
    }
  }

  files::TomlTable& table_;
  std::mt19937_64& random_;
  std::vector<CommandStretch>& to_;
  Setpoint setpoint_;
  CommandStretch common_;
};

}  // namespace

std::vector<CommandStretch> read_commands(std::vector<files::TomlTable> tables,
                                          std::mt19937_64& random) {
  std::vector<CommandStretch> stretches;
  for (files::TomlTable& table : tables) {
    Maker(table, random, stretches).make();
    table.finish();
  }
  return stretches;
}

CommandProgram::CommandProgram(std::vector<CommandStretch> stretches)
    : stretches_(std::move(stretches)) {
  for (const CommandStretch& stretch : stretches_) {
    duration_s_ += stretch.seconds;
  }
}

Command<double> CommandProgram::at(double time_s) {
  while (now_ + 1 < stretches_.size() && time_s >= began_s_ + stretches_[now_].seconds - 1e-9) {
    began_s_ += stretches_[now_].seconds;
    ++now_;
  }
  const CommandStretch& stretch = stretches_[now_];
  const double in_s = std::min(time_s - began_s_, stretch.seconds);
  Command<double> command = stretch.command;
  command.fresh = !stretch.silent;
  command.setpoint += (stretch.end - command.setpoint) * (in_s / stretch.seconds);
  if (stretch.amplitude != 0) {
    // φ = 2π f0 T/ln k (k^(t/T) - 1), k = f1/f0
    const double growth = std::log(stretch.to_Hz / stretch.from_Hz);
    const double share = in_s / stretch.seconds;
    const double cycles =
        growth == 0 ? stretch.from_Hz * in_s
                    : stretch.from_Hz * stretch.seconds / growth * std::expm1(growth * share);
    command.setpoint += stretch.amplitude * std::sin(2 * std::numbers::pi * cycles);
  }
  return command;
}

}  // namespace smaservo::bench
