#include "host-sim/evaluate/closed_loop/closed_loop.hpp"

#include <algorithm>
#include <cmath>

#include "firmware/bench/dice.hpp"
#include "host-sim/evaluate/runs/runs.hpp"
#include "host-sim/parallel.hpp"
#include "model/files/output_file.hpp"

namespace smaservo::evaluate {
namespace {

constexpr double in_time_s = 0.10;
constexpr double in_time_ratio = 1.3;
constexpr std::size_t device_at = 0;
constexpr std::size_t ideal_at = 1;
static_assert(loop_kinds[device_at] == LoopKind::device && loop_kinds[ideal_at] == LoopKind::ideal);

std::function<void(std::size_t)> reporting(const ClosedLoopOptions& options, std::string_view stage,
                                           std::size_t total) {
  const auto report = [&options, stage, total](std::size_t done) {
    if (options.progress) {
      options.progress(stage, done, total);
    }
  };
  report(0);
  return report;
}

std::vector<KnownUnit> known_units(const ClosedLoopOptions& options) {
  if (!options.wires.empty()) {
    files::prepare_folder("--wires", options.wires);
  }
  std::vector<KnownUnit> units(static_cast<std::size_t>(options.units) *
                               hal::tuning_families.size());
  parallel(
      units.size(), options.threads,
      [&](std::size_t i) {
        units[i] = known_unit(hal::tuning_families.at(i % hal::tuning_families.size()),
                              options.seed + i / hal::tuning_families.size(), options.wires);
      },
      reporting(options, "calibration", units.size()));
  return units;
}

LoopConditions conditions(LoopRow row, std::uint64_t seed) {
  bench::Dice dice(seed);
  LoopConditions c{};
  c.load_gain = 1 + dice.uniform(-0.005, 0.005);
  switch (row) {
    case LoopRow::weights:
      c.load = hal::ConstantLoad{MPa * dice.uniform(100, 300)};
      break;
    case LoopRow::spring: {
      const double low_MPa = dice.uniform(100, 140);
      c.load = hal::SpringLoad{MPa * low_MPa, MPa * dice.uniform(220, 300), 0.04, 0.02};
      break;
    }
    case LoopRow::light:
      c.load = hal::ConstantLoad{50 * MPa};
      break;
  }
  return c;
}

void count(LoopFigures& figures, const LoopRun& run, const LoopRun& ideal_run) {
  for (std::size_t i = 0; i < run.steps.size(); ++i) {
    const LoopStep& step = run.steps[i];
    figures.error.add(step.error_percent);
    figures.cycles += step.reversals > 1 ? 1 : 0;
    if (step.heats) {
      figures.heating_s.push_back(step.settled_s);
      figures.heated_in_time += step.settled_s <= in_time_s ? 1 : 0;
    } else {
      figures.cooling_s.push_back(step.settled_s);
      const double limit_s = in_time_ratio * ideal_run.steps[i].settled_s;
      figures.cooled_in_time += step.settled_s <= limit_s && std::isfinite(step.settled_s) ? 1 : 0;
    }
  }
  figures.above_limit_K = std::max(figures.above_limit_K, run.above_limit_K);
  if (run.tripped != Fault::none) {
    figures.trips.push_back(run.tripped);
  }
}

/// Figures of no run yet.
LoopFigures no_runs() {
  LoopFigures figures;
  figures.above_limit_K = -1000;
  return figures;
}

void sort_times(LoopFigures& figures) {
  std::ranges::sort(figures.heating_s);
  std::ranges::sort(figures.cooling_s);
}

LoopRowResult evaluate_row(LoopRow row, const std::vector<KnownUnit>& units,
                           const ClosedLoopOptions& options) {
  const auto runs = static_cast<std::size_t>(options.runs);
  std::vector<std::array<LoopRun, loop_kinds.size()>> results(runs);
  parallel(
      runs * loop_kinds.size(), options.threads,
      [&](std::size_t i) {
        const std::size_t run = i / loop_kinds.size();
        const std::size_t kind = i % loop_kinds.size();
        // All rows of the table use the same seeds, so they differ only by their loads.
        const std::uint64_t seed = 100'000 * options.seed + run;
        results[run].at(kind) = run_steps(loop_kinds.at(kind), units[run % units.size()],
                                          conditions(row, seed), options.steps, seed);
      },
      reporting(options, "steps", runs * loop_kinds.size()));
  LoopRowResult result{row, {}, {}};
  result.kinds.fill(no_runs());
  result.device_by_family.fill(no_runs());
  for (std::size_t run = 0; run < runs; ++run) {
    const LoopRun& ideal_run = results[run][ideal_at];
    for (std::size_t kind = 0; kind < loop_kinds.size(); ++kind) {
      count(result.kinds.at(kind), results[run].at(kind), ideal_run);
    }
    // The units of the families take turns (known_units).
    count(result.device_by_family.at(run % hal::tuning_families.size()), results[run][device_at],
          ideal_run);
  }
  std::ranges::for_each(result.kinds, sort_times);
  std::ranges::for_each(result.device_by_family, sort_times);
  return result;
}

/// Judges steps and sines of every controller.
void judge_loops(ClosedLoopEvaluation& result, const std::vector<KnownUnit>& units,
                 const ClosedLoopOptions& options) {
  for (const LoopRow row : closed_loop_rows) {
    result.rows.push_back(evaluate_row(row, units, options));
  }
  for (auto& of_kind : result.bandwidth_Hz) {
    of_kind.resize(units.size());
  }
  const std::size_t total = units.size() * loop_kinds.size();
  parallel(
      total, options.threads,
      [&](std::size_t i) {
        const LoopConditions at{hal::ConstantLoad{200 * MPa}};
        result.bandwidth_Hz.at(i % loop_kinds.size())[i / loop_kinds.size()] = bandwidth_Hz(
            loop_kinds.at(i % loop_kinds.size()), units[i / loop_kinds.size()], at, options.seed);
      },
      reporting(options, "sines", total));
}

}  // namespace

double LoopFigures::quantile_s(bool heats, double share) const {
  const std::vector<double>& all = heats ? heating_s : cooling_s;
  if (all.empty()) {
    return std::nan("");
  }
  const double place = std::ceil(share * static_cast<double>(all.size()));
  return all[static_cast<std::size_t>(std::max(place, 1.0)) - 1];
}

ClosedLoopEvaluation evaluate_closed_loop(const ClosedLoopOptions& options) {
  const std::vector<KnownUnit> units = known_units(options);
  ClosedLoopEvaluation result{
      options.units, options.seed, units.front().wire.nominal_stroke, {}, {}, {}};
  if (!options.random_from) {
    judge_loops(result, units, options);
  }
  std::vector<CalibratedUnit> calibrated;
  calibrated.reserve(units.size());
  for (const KnownUnit& known : units) {
    calibrated.push_back({known.unit, known.wire});
  }
  const auto scenarios = static_cast<std::size_t>(options.random);
  result.hottest =
      run_hottest(calibrated, options.random_from.value_or(100'000 * options.seed), options.random,
                  options.threads, reporting(options, "random scenarios", scenarios));
  return result;
}

}  // namespace smaservo::evaluate
