#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <limits>
#include <string>
#include <string_view>

#include "firmware/text/device_names.hpp"
#include "host-sim/campaign/kinds/kinds.hpp"
#include "host-sim/evaluate/closed_loop/hottest.hpp"
#include "host-sim/evaluate/runs/calibrate.hpp"
#include "host-sim/shell_word.hpp"
#include "model/files/error.hpp"
#include "model/files/toml/toml_fields.hpp"

namespace smaservo::campaign {
namespace {

/// The enumerator with this name, of the first `count`.
template <class Enum>
Enum named(std::string_view text, std::size_t count, std::string_view (*name)(Enum)) {
  for (std::size_t i = 0; i < count; ++i) {
    if (name(static_cast<Enum>(i)) == text) {
      return static_cast<Enum>(i);
    }
  }
  throw files::UserError(
      fmt::format("a scenario has {}, which there is not", files::quoted(std::string(text))));
}

double number_or(const std::string& cell, double otherwise) {
  return cell.empty() ? otherwise : std::stod(cell);
}

/// The table of firmware/README.md.
class HottestTable final : public Table {
 public:
  void add(const std::vector<std::string>& c) override {
    constexpr double never = std::numeric_limits<double>::infinity();
    runs_.push_back({std::stoull(c.at(0)), named(c.at(1), mode_count, text::mode_name),
                     named(c.at(2), evaluate::random_air_count, evaluate::random_air_name),
                     named(c.at(3), evaluate::random_trouble_count, evaluate::random_trouble_name),
                     c.at(5) == yes_or_no(true), std::stod(c.at(6)), std::stod(c.at(7)),
                     std::stod(c.at(8)), named(c.at(9), fault_count, fault_name),
                     number_or(c.at(10), never), std::stod(c.at(11)), c.at(12) == yes_or_no(true),
                     c.at(13) == yes_or_no(true)});
  }
  void add(const TrialFile& /*file*/) override {}
  std::string text() const override { return ""; }
  std::string markdown() const override { return evaluate::hottest_markdown(runs_); }
  std::string_view mark() const override { return "random scenarios"; }

 private:
  std::vector<evaluate::HottestRun> runs_;
};

/// What the wires are drawn with: `units` of each family, with seeds from `unit_seed` on.
struct ScenarioUnits {
  int units;
  std::uint64_t unit_seed;
  std::string wires;
};

class Scenarios final : public Trials {
 public:
  Scenarios(std::uint64_t seed, ScenarioUnits from)
      : seed_(seed),
        from_(std::move(from)),
        units_(evaluate::calibrated_units(from_.units, from_.unit_seed, from_.wires)) {}

  const std::vector<Column>& columns() const override {
    static const std::vector<Column> all{{"seed", true},
                                         {"mode", true, true},
                                         {"air", true, true},
                                         {"trouble", true, true},
                                         {"second_trouble", true, true},
                                         {"beyond", true, true},
                                         {"duration_s", true},
                                         {"above_limit_K", false},
                                         {"at_s", false},
                                         {"first_cause", false, true},
                                         {"tripped_s", false},
                                         {"over_s", false},
                                         {"unanswered", false, true},
                                         {"cooling_halved", false, true}};
    return all;
  }
  std::string_view main_column() const override { return "above_limit_K"; }
  double cost_s() const override { return 0.15; }

  TrialResult run(std::uint64_t index, const Stop& /*stop*/) const override {
    const evaluate::RandomScenario scenario = evaluate::random_scenario(units_, seed_ + index);
    const evaluate::HottestRun run = evaluate::run_hottest(scenario);
    constexpr double none = std::numeric_limits<double>::quiet_NaN();
    return {{seed_ + index, std::string(text::mode_name(run.mode)),
             std::string(evaluate::random_air_name(run.air)),
             std::string(evaluate::random_trouble_name(run.trouble)),
             std::string(evaluate::random_trouble_name(scenario.second)), yes_or_no(run.beyond),
             run.duration_s, run.above_limit_K, run.at_s, std::string(fault_name(run.first_cause)),
             std::isfinite(run.tripped_s) ? run.tripped_s : none, run.over_s,
             yes_or_no(run.unanswered), yes_or_no(run.halved)}};
  }

  std::string command(std::uint64_t index) const override {
    return fmt::format(
        "host-sim evaluate --closed-loop --units {} --seed {} --wires {} --random-seed {}",
        from_.units, from_.unit_seed, shell_word(from_.wires), seed_ + index);
  }

  std::unique_ptr<Table> table() const override { return std::make_unique<HottestTable>(); }

 private:
  std::uint64_t seed_;
  ScenarioUnits from_;
  std::vector<evaluate::CalibratedUnit> units_;
};

}  // namespace

std::unique_ptr<const Trials> read_scenarios(KindTable& table) {
  constexpr double most_units = 1000;
  constexpr double greatest_unit_seed = 1e9;
  ScenarioUnits from{static_cast<int>(table.whole("units", 1, most_units, 3)),
                     table.whole("unit_seed", 0, greatest_unit_seed, 1000), table.path("wires")};
  for (int i = 0; i < from.units; ++i) {
    for (const hal::Family family : hal::tuning_families) {
      const std::string name =
          evaluate::calibrated_name(family, from.unit_seed + static_cast<std::uint64_t>(i));
      const std::string path = (std::filesystem::path(from.wires) / name).string();
      std::error_code ignored;
      if (!std::filesystem::exists(path, ignored)) {
        table.keys().fail(
            "wires", fmt::format("{}: there is no such wire; it is calibrated, in a minute, by: "
                                 "host-sim evaluate --closed-loop --random-from 0 --random 1 "
                                 "--units {} --seed {} --wires {}",
                                 path, from.units, from.unit_seed, from.wires));
      }
      table.depends_on("wires", name, path);
    }
  }
  return std::make_unique<Scenarios>(table.plan().seed, std::move(from));
}

}  // namespace smaservo::campaign
