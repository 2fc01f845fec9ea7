#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>

#include "firmware/bench/closed_loop.hpp"
#include "firmware/bench/scenario/units.hpp"
#include "firmware/text/settings_file.hpp"
#include "host-sim/campaign/kinds/drawn_units.hpp"
#include "host-sim/campaign/kinds/kinds.hpp"
#include "host-sim/report/step_figures.hpp"
#include "host-sim/shell_word.hpp"
#include "host-sim/simulate/closed_loop_run.hpp"
#include "model/files/error.hpp"

namespace smaservo::campaign {
namespace {

constexpr double no_number = std::numeric_limits<double>::quiet_NaN();
/// A wire whose diameter differs more from the preset's is none of its type.
constexpr double same_type = 0.05;
/// Seconds of one core for a second of a closed loop.
constexpr double loop_cost = 0.0025;

/// How the true wire follows the set-points. Errors are in per cent of the nominal stroke.
class FollowingErrors {
 public:
  explicit FollowingErrors(const bench::ClosedLoopScenario& scenario)
      : settings_(scenario.settings),
        steps_(scenario.settings.wire.nominal_stroke, scenario.settings.timing.period_s) {}

  void add(const bench::SimulatedCycle& cycle) {
    const Output<double>& out = cycle.output;
    const bool runs = out.state == DeviceState::running;
    const double demanded =
        simulate::wanted_strain(settings_, cycle.command.mode, cycle.command.setpoint);
    // A device that has tripped still owes what is demanded.
    add_error(cycle.truth.strain -
              (runs ? simulate::wanted_strain(settings_, out.mode, out.reference) : demanded));
    steps_.add(cycle.time_s, runs ? demanded : no_number, cycle.truth.strain);
    if (first_fault_ == Fault::none && out.first_cause != Fault::none) {
      first_fault_ = out.first_cause;
      fault_s_ = cycle.time_s;
    }
    above_limit_K_ =
        std::max(above_limit_K_, cycle.truth.hottest_K - settings_.limits.temperature_K);
  }

  void append_to(Row& row) {
    steps_.finish();
    double steady = 0;
    double settling_s = no_number;
    std::uint64_t unsettled = 0;
    for (const report::StepFigures& step : steps_.steps()) {
      steady += step.error_percent;
      unsettled += report::is_unreached(step) ? 1U : 0U;
      settling_s = std::fmax(settling_s, step.settling_s);
    }
    const auto count = static_cast<double>(count_);
    const std::size_t steps = steps_.steps().size();
    row.insert(
        row.end(),
        {std::sqrt(squares_ / count), sum_ / count, count_ == 0 ? no_number : greatest_,
         steps == 0 ? no_number : steady / static_cast<double>(steps), std::uint64_t{steps},
         unsettled, settling_s, above_limit_K_, std::string(fault_name(first_fault_)), fault_s_});
  }

 private:
  void add_error(double strain) {
    if (std::isnan(strain)) {
      return;
    }
    const double percent = 100 * std::abs(strain) / settings_.wire.nominal_stroke;
    ++count_;
    sum_ += percent;
    squares_ += percent * percent;
    greatest_ = std::max(greatest_, percent);
  }

  const Settings<double>& settings_;
  report::StepJudge steps_;
  std::uint64_t count_ = 0;
  double sum_ = 0, squares_ = 0, greatest_ = 0;
  double above_limit_K_ = -std::numeric_limits<double>::infinity();
  Fault first_fault_ = Fault::none;
  double fault_s_ = no_number;
};

class Gains final : public Trials {
 public:
  Gains(const Plan& plan, bench::ClosedLoopScenario scenario, std::vector<hal::Family> families)
      : path_(plan.path),
        seed_(plan.seed),
        scenario_(std::move(scenario)),
        families_(std::move(families)) {}

  const std::vector<Column>& columns() const override {
    static const std::vector<Column> all = with_unit_columns({{"rms_error_percent", false},
                                                              {"mean_error_percent", false},
                                                              {"max_error_percent", false},
                                                              {"steady_error_percent", false},
                                                              {"steps", false},
                                                              {"unsettled_steps", false},
                                                              {"worst_settling_s", false},
                                                              {"above_limit_K", false},
                                                              {"first_fault", false, true},
                                                              {"fault_s", false}});
    return all;
  }
  std::string_view main_column() const override { return "rms_error_percent"; }
  double cost_s() const override { return loop_cost * scenario_.duration_s; }

  TrialResult run(std::uint64_t index, const Stop& /*stop*/) const override {
    const bench::WireUnit unit = unit_of(index);
    bench::ClosedLoopScenario scenario = scenario_;
    scenario.plant = {bench::plant_family(unit.family), unit.wire, unit.scatter_K, unit.structure,
                      seed_ + index};
    scenario.board.geometry = unit.wire.wire.geometry;
    scenario.board.seed = seed_ + index;
    Row row = unit_cells(unit, seed_ + index);
    FollowingErrors errors(scenario);
    bench::ClosedLoop loop(scenario);
    while (loop.step()) {
      errors.add(loop.cycle());
    }
    errors.append_to(row);
    return {std::move(row)};
  }

  std::string command(std::uint64_t index) const override {
    return fmt::format("host-sim campaign {} --trial {}", shell_word(path_), index);
  }

 private:
  bench::WireUnit unit_of(std::uint64_t index) const {
    const hal::Family family = families_[static_cast<std::size_t>(index % families_.size())];
    return index == 0 ? nominal_unit(family) : bench::random_unit(family, seed_ + index);
  }

  std::string path_;
  std::uint64_t seed_;
  bench::ClosedLoopScenario scenario_;
  std::vector<hal::Family> families_;
};

}  // namespace

std::unique_ptr<const Trials> read_gains(KindTable& table) {
  const std::string path = table.path("scenario");
  table.depends_on("scenario", table.keys().text("scenario"), path);
  if (!bench::is_closed_loop(path)) {
    table.keys().fail("scenario", "must be that of a closed loop: it has no [device]");
  }
  bench::ClosedLoopScenario scenario = bench::load_closed_loop(path);
  if (scenario.pair) {
    table.keys().fail("scenario", "has a [pair]; only one wire is drawn here");
  }
  const double diameter_m = nominal_unit(hal::Family::ihyp).wire.wire.geometry.diameter_m;
  const double known_m = scenario.settings.wire.geometry.diameter_m;
  if (std::abs(known_m / diameter_m - 1) > same_type) {
    table.keys().fail(
        "scenario",
        fmt::format("its device has a wire of {:.4g} um; the tolerance is known of {} alone, with "
                    "{:.4g} um",
                    1e6 * known_m, files::default_wire, 1e6 * diameter_m));
  }
  // All that the device knows, wherever its file has it from.
  table.depends_on_text("settings of the device", text::to_toml(scenario.settings));
  return std::make_unique<Gains>(table.plan(), std::move(scenario), families_of(table));
}

}  // namespace smaservo::campaign
