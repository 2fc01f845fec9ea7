#include "host-sim/evaluate/evaluate.hpp"

#include <algorithm>
#include <filesystem>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <memory>
#include <optional>
#include <utility>

#include "host-sim/end_by_signal.hpp"
#include "host-sim/evaluate/observer_program.hpp"
#include "host-sim/evaluate/runs/calibrate.hpp"
#include "host-sim/evaluate/runs/commissioned.hpp"
#include "host-sim/parallel.hpp"
#include "host-sim/replay/measurement_params.hpp"
#include "host-sim/replay/observers.hpp"
#include "host-sim/simulate/simulate.hpp"
#include "model/files/error.hpp"
#include "model/files/output_file.hpp"

namespace smaservo::evaluate {
namespace {

constexpr std::string_view model_alone = "open-loop";

/// The seed of a run, far from the seeds of units. It is the same in all rows, so rows differ only
/// by their conditions.
std::uint64_t run_seed(const EvaluateOptions& options, std::size_t run) {
  return 100'000 * options.seed + run;
}

struct JudgedUnit {
  bench::WireUnit unit;
  Wire<double> type_file, commissioned, read_stroke, two_readings, calibrated;

  const Wire<double>& known(Known what) const {
    switch (what) {
      case Known::type:
        return type_file;
      case Known::commissioned:
        return commissioned;
      case Known::read_stroke:
        return read_stroke;
      case Known::two_readings:
        return two_readings;
      case Known::calibrated:
        break;
    }
    return calibrated;
  }
};

/// An observer of the table.
struct Judged {
  std::string name;
  std::string program;  ///< empty: one of replay::observer_kinds()
};

/// One run in the work list.
struct Job {
  std::size_t row;
  std::size_t unit;
  EvaluatedRun run;
};

std::vector<std::size_t> chosen_rows(const EvaluateOptions& options) {
  const std::vector<EvaluationRow>& all = evaluation_rows();
  std::vector<std::string_view> names;
  std::vector<std::size_t> chosen;
  for (std::size_t i = 0; i < all.size(); ++i) {
    names.push_back(all[i].name);
    if (options.rows.empty() || std::ranges::count(options.rows, all[i].name) > 0) {
      chosen.push_back(i);
    }
  }
  for (const std::string& name : options.rows) {
    if (std::ranges::count(names, name) == 0) {
      throw files::UserError(
          fmt::format("--row {}: no such row; there are: {}", name, fmt::join(names, ", ")));
    }
  }
  return chosen;
}

void require(const char* option, std::int64_t value, std::int64_t min, std::int64_t max) {
  if (value < min || value > max) {
    throw files::UserError(
        fmt::format("{} {}: must be between {} and {}", option, value, min, max));
  }
}

void check(const EvaluateOptions& options, const replay::RunSettings& settings) {
  require("--units", options.units, 1, 1000);
  require("--runs", options.runs, 0, 100'000);
  require("--threads", options.threads, 1, 1000);
  if (options.seed > 1'000'000'000) {
    throw files::UserError(fmt::format("--seed {}: must be at most 1000000000", options.seed));
  }
  const Wire<double> preset = files::load_wire(std::string(files::default_wire)).wire;
  for (auto name = options.observers.begin(); name != options.observers.end(); ++name) {
    replay::make_observer(*name, preset, settings, {}, room_K);
    if (std::find(options.observers.begin(), name, *name) != name) {
      throw files::UserError(fmt::format("--observer {}: is given twice", *name));
    }
  }
  std::ranges::for_each(options.programs, check_observer_program);
  observer_program_names(options.programs);
}

std::function<void(std::size_t)> reporting(const EvaluateOptions& options, std::string_view stage,
                                           std::size_t total) {
  const auto report = [&options, stage, total](std::size_t done) {
    if (options.progress) {
      options.progress(stage, done, total);
    }
  };
  report(0);
  return report;
}

std::vector<JudgedUnit> make_units(const EvaluateOptions& options) {
  std::vector<JudgedUnit> units;
  for (int i = 0; i < options.units; ++i) {
    for (const hal::Family family : options.families) {
      const bench::WireUnit unit =
          bench::random_unit(family, options.seed + static_cast<std::uint64_t>(i));
      units.push_back({unit, unit.type_file(), {}, {}, {}, {}});
    }
  }
  return units;
}

void calibrate(const EvaluateOptions& options, std::vector<JudgedUnit>& units) {
  if (!options.wires.empty()) {
    files::prepare_folder("--wires", options.wires);
  }
  parallel(
      units.size(), options.threads,
      [&](std::size_t i) {
        units[i].calibrated =
            options.calibrated ? options.calibrated(units[i].unit)
                               : calibrated_wire(units[i].unit, options.wires, options.structure);
      },
      reporting(options, "calibration", units.size()));
}

void commission(const EvaluateOptions& options, const std::vector<std::size_t>& rows,
                std::vector<JudgedUnit>& units) {
  const auto asked = [&](Known what) {
    return std::ranges::any_of(
        rows, [&](std::size_t row) { return evaluation_rows()[row].known == what; });
  };
  const bool nothing = asked(Known::commissioned);
  const bool stroke = asked(Known::read_stroke);
  const bool lengths = asked(Known::two_readings);
  if (!nothing && !stroke && !lengths) {
    return;
  }
  parallel(
      units.size(), options.threads,
      [&](std::size_t i) {
        JudgedUnit& unit = units[i];
        const auto wire = [&](bool needed, Read read) {
          return needed ? commissioned_wire(unit.unit, read) : unit.type_file;
        };
        unit.commissioned = wire(nothing, Read::nothing);
        unit.read_stroke = wire(stroke, Read::stroke);
        unit.two_readings = wire(lengths, Read::lengths);
      },
      reporting(options, "commissioning", units.size()));
}

/// The runs of a row use all units in turn, then the next condition; after all conditions they
/// change from undisturbed to disturbed or back.
std::vector<Job> work_list(const EvaluateOptions& options, const std::vector<std::size_t>& rows,
                           const std::vector<JudgedUnit>& units) {
  std::vector<Job> jobs;
  for (const std::size_t index : rows) {
    const EvaluationRow& row = evaluation_rows()[index];
    const std::size_t runs = options.runs > 0 ? static_cast<std::size_t>(options.runs)
                                              : static_cast<std::size_t>(row.runs) * units.size();
    for (std::size_t i = 0; i < runs; ++i) {
      const std::size_t at = i % units.size();
      const std::size_t round = i / units.size();
      const bool disturbed =
          row.disturbed == Disturbed::always ||
          (row.disturbed == Disturbed::every_other && round / row.conditions.size() % 2 == 1);
      const bench::WireUnit& unit = units[at].unit;
      jobs.push_back({index,
                      at,
                      {unit.family, unit.seed, row.conditions[round % row.conditions.size()],
                       disturbed, run_seed(options, i)}});
    }
  }
  return jobs;
}

/// The observers of a row. In a hold the model alone is added, to show its uncorrected drift.
std::vector<Judged> observers_of(const EvaluateOptions& options, std::size_t row) {
  std::vector<Judged> observers;
  observers.reserve(options.observers.size() + options.programs.size() + 1);
  for (const std::string& name : options.observers) {
    observers.push_back({name, ""});
  }
  const std::vector<std::string> names = observer_program_names(options.programs);
  for (std::size_t i = 0; i < names.size(); ++i) {
    observers.push_back({names[i], options.programs[i]});
  }
  const bool hold = evaluation_rows()[row].conditions.front() == Condition::hold_ripple;
  if (hold && std::ranges::count(observers, model_alone, &Judged::name) == 0) {
    observers.push_back({std::string(model_alone), ""});
  }
  return observers;
}

/// The least current that a user of these converters would set: below 160 steps of the current's
/// converter the resistance may have a constant error of 0.3 %.
double min_current_A(const hal::Sensors& sensors) {
  return 160 * sensors.current_full_scale_A / std::ldexp(1.0, sensors.bits - 1);
}

std::vector<JudgedRow> observe(const std::string& observer, const Wire<double>& wire,
                               const replay::RunSettings& settings, const hal::Sensors& sensors,
                               const std::vector<simulate::SimulatedRow>& rows) {
  MeasurementParams<double> measurement = replay::measurement_params(wire, settings);
  measurement.min_current_A = std::max(measurement.min_current_A, min_current_A(sensors));
  std::unique_ptr<replay::AnyObserver> running;
  std::vector<JudgedRow> judged;
  judged.reserve(rows.size());
  for (const simulate::SimulatedRow& row : rows) {
    const Measurement<double> m =
        measure(measurement, Sample<double>{row.current_A, row.voltage_V, row.load_N});
    if (running) {
      running->advance(m, row.time_s - judged.back().time_s);
    } else {
      running = replay::make_observer(observer, wire, settings, m, room_K);
    }
    const Estimate<double> e = running->estimate();
    judged.push_back({row.time_s, row.strain, e.strain, e.strain_sd, e.health});
  }
  return judged;
}

std::vector<simulate::SimulatedRow> simulated(const bench::Scenario& scenario) {
  std::vector<simulate::SimulatedRow> rows;
  simulate::simulate_rows(scenario,
                          [&](const simulate::SimulatedRow& row) { rows.push_back(row); });
  return rows;
}

/// A program reports no health, so that its health counts as good.
std::vector<JudgedRow> observe_by_program(const std::string& program, const Wire<double>& wire,
                                          const Job& job,
                                          const std::vector<simulate::SimulatedRow>& rows) {
  const std::string run = fmt::format("{}, {}", evaluation_rows()[job.row].name, run_text(job.run));
  const std::vector<ProgramAnswer> answers = ask_observer_program(program, wire, rows, run);
  std::vector<JudgedRow> judged;
  judged.reserve(rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    judged.push_back(
        {rows[i].time_s, rows[i].strain, answers[i].strain, answers[i].strain_sd, Health::good});
  }
  return judged;
}

/// Runs each program once, so that its mistakes are found before the calibration, which may take
/// an hour.
void try_programs(const EvaluateOptions& options, const Job& job, const JudgedUnit& unit) {
  if (options.programs.empty()) {
    return;
  }
  const std::vector<simulate::SimulatedRow> rows =
      simulated(test_run(unit.unit, job.run.condition, job.run.seed, job.run.disturbed));
  for (const std::string& program : options.programs) {
    observe_by_program(program, unit.type_file, job, rows);
  }
}

JudgedRun judge(const Job& job, const bench::JouleScenario& joule,
                const std::vector<JudgedRow>& rows, double stroke) {
  const EvaluatedRun& run = job.run;
  JudgedRun judged{.run = run,
                   .figures = judge_errors(rows, stroke, evaluation_rows()[job.row].counted),
                   .start = {}};
  if (run.condition == Condition::hold_ripple) {
    double begin_s = -joule.record_from_s;
    const auto ripple = std::ranges::find_if(
        joule.drive, [](const bench::DriveStep& step) { return step.ripple > 0; });
    for (auto step = joule.drive.begin(); step != ripple; ++step) {
      begin_s += step->seconds;
    }
    judged.drift_percent = hold_drift_percent(rows, stroke, begin_s, begin_s + ripple->seconds);
  }
  if (run.condition == Condition::unknown_start) {
    judged.start = judge_start(rows, stroke);
  }
  return judged;
}

/// Simulates a run once and gives it to all observers of its row.
std::vector<JudgedRun> judge(const EvaluateOptions& options, const replay::RunSettings& settings,
                             const Job& job, const JudgedUnit& unit, double stroke) {
  const bench::Scenario scenario =
      test_run(unit.unit, job.run.condition, job.run.seed, job.run.disturbed);
  const std::vector<simulate::SimulatedRow> rows = simulated(scenario);
  const Wire<double>& wire = unit.known(evaluation_rows()[job.row].known);
  const auto& joule = std::get<bench::JouleScenario>(scenario.run);
  std::vector<JudgedRun> judged;
  for (const Judged& observer : observers_of(options, job.row)) {
    const std::vector<JudgedRow> observed =
        observer.program.empty() ? observe(observer.name, wire, settings, joule.sensors, rows)
                                 : observe_by_program(observer.program, wire, job, rows);
    judged.push_back(judge(job, joule, observed, stroke));
  }
  return judged;
}

/// Only while programs of others run: without them a signal ends this one as usual.
std::optional<EndBySignal> ends_programs(const EvaluateOptions& options) {
  return options.programs.empty() ? std::nullopt : std::optional<EndBySignal>(std::in_place);
}

}  // namespace

RowSum::RowSum(const std::vector<hal::Family>& families, std::size_t row) : row_(row) {
  for (const hal::Family family : families) {
    by_family_.emplace_back(family, PooledRuns());
  }
}

void RowSum::add(const JudgedRun& run) {
  all_.add(run);
  for (auto& [family, sum] : by_family_) {
    if (family == run.run.family) {
      sum.add(run);
    }
  }
}

RowResult RowSum::result(std::vector<JudgedRun> runs) const {
  RowResult result{row_, std::move(runs), all_.figures(), {}};
  for (const auto& [family, sum] : by_family_) {
    result.by_family.push_back({family, sum.figures()});
  }
  return result;
}

Evaluation evaluate(const EvaluateOptions& options) {
  const replay::RunSettings settings = replay::parse_run_settings(options.settings);
  check(options, settings);
  const std::vector<std::size_t> rows = chosen_rows(options);
  const bool calibrated = std::ranges::any_of(
      rows, [](std::size_t row) { return evaluation_rows()[row].known == Known::calibrated; });
  std::vector<JudgedUnit> units = make_units(options);
  const std::vector<Job> jobs = work_list(options, rows, units);
  if (calibrated) {
    const std::optional<EndBySignal> end = ends_programs(options);
    try_programs(options, jobs.front(), units[jobs.front().unit]);
  }
  if (calibrated) {
    calibrate(options, units);
  }
  commission(options, rows, units);
  const std::optional<EndBySignal> end = ends_programs(options);
  const double stroke = units.front().type_file.nominal_stroke;
  std::vector<std::vector<JudgedRun>> judged(jobs.size());
  parallel(
      jobs.size(), options.threads,
      [&](std::size_t i) {
        judged[i] = judge(options, settings, jobs[i], units[jobs[i].unit], stroke);
      },
      reporting(options, "runs", jobs.size()));

  Evaluation evaluation{stroke, options.units, options.seed, {}};
  for (const std::size_t row : rows) {
    const std::vector<Judged> observers = observers_of(options, row);
    for (std::size_t i = 0; i < observers.size(); ++i) {
      RowSum sum(options.families, row);
      std::vector<JudgedRun> runs;
      for (std::size_t job = 0; job < jobs.size(); ++job) {
        if (jobs[job].row == row) {
          sum.add(judged[job][i]);
          runs.push_back(std::move(judged[job][i]));
        }
      }
      if (i == evaluation.observers.size()) {
        evaluation.observers.push_back({observers[i].name, {}});
      }
      evaluation.observers[i].rows.push_back(sum.result(std::move(runs)));
    }
  }
  return evaluation;
}

}  // namespace smaservo::evaluate
