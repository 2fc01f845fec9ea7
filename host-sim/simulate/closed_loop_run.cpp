#include "host-sim/simulate/closed_loop_run.hpp"

#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <memory>

#include "firmware/bench/closed_loop.hpp"
#include "firmware/safety/failsafe.hpp"
#include "firmware/text/device_names.hpp"
#include "firmware/text/device_trace.hpp"
#include "model/files/message.hpp"
#include "model/units.hpp"

namespace smaservo::simulate {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double estimate_settles_s = 1;

// The limits of a step, for StepControl: limit reasons, and above them the limiting warnings, which
// `protection` stands for.
constexpr unsigned first_warning_bit = 16;
static_assert(static_cast<unsigned>(LimitReason::count) <= first_warning_bit);
static_assert(std::popcount(limiting_faults.bits()) <= 32 - static_cast<int>(first_warning_bit));

std::uint32_t bits_of(FaultSet warnings) {
  std::uint32_t bits = 0;
  unsigned bit = first_warning_bit;
  for_each_fault(limiting_faults, [&](Fault fault) {
    bits |= warnings.has(fault) ? 1U << bit : 0U;
    ++bit;
  });
  return bits;
}

FaultSet warnings_of(std::uint32_t bits) {
  FaultSet warnings;
  unsigned bit = first_warning_bit;
  for_each_fault(limiting_faults,
                 [&](Fault fault) { warnings.set(fault, (bits >> bit++ & 1U) != 0); });
  return warnings;
}

/// The variable that a mode controls, as the device measures it.
double controlled(const bench::SimulatedCycle& cycle) {
  const Sample<double>& sample = cycle.inputs.sample;
  switch (cycle.output.mode) {
    case Mode::current:
      return sample.current_A;
    case Mode::power:
      return sample.current_A * sample.voltage_V;
    case Mode::resistance:
      return cycle.output.measurement.resistance_valid ? cycle.output.measurement.resistance_ohm
                                                       : nan;
    case Mode::temperature:
      return cycle.output.estimate.temperature_K;
    case Mode::force:
      return sample.load_N;
    case Mode::off:
    case Mode::strain:
    case Mode::position:
    case Mode::identification:
      break;
  }
  return nan;
}

/// Collects the data that a report shows.
class Recorder {
 public:
  Recorder(const bench::ClosedLoopScenario& scenario, LoopRecord& record)
      : settings_(scenario.settings), record_(record), gap_s_(scenario.duration_s / 500) {}

  void add(const bench::SimulatedCycle& cycle) {
    const Output<double>& out = cycle.output;
    const bool length = out.mode == Mode::strain || out.mode == Mode::position;
    const double controlled_now = controlled(cycle);
    const bool other = !std::isnan(controlled_now);
    const double stroke = settings_.wire.nominal_stroke;
    const double reference = length ? wanted_strain(settings_, out.mode, out.reference) : nan;
    record_.series.add(
        {.time_s = cycle.time_s,
         .setpoint_percent =
             100 * wanted_strain(settings_, cycle.command.mode, cycle.command.setpoint),
         .reference_percent = 100 * reference,
         .strain_percent = 100 * cycle.truth.strain,
         .estimate_percent = 100 * out.estimate.strain,
         .estimate_error_percent = 100 * (out.estimate.strain - cycle.truth.strain) / stroke,
         .control_error_percent = 100 * (cycle.truth.strain - reference) / stroke,
         .current_A = cycle.truth.current_A,
         .power_W = out.wanted_power_W,
         .wire_degC = out.estimate.temperature_K - zero_degC_K,
         .hot_spot_degC = out.hot_spot_K > 0 ? out.hot_spot_K - zero_degC_K : nan,
         .hottest_degC = cycle.truth.hottest_K - zero_degC_K,
         .stress_MPa = cycle.truth.stress_Pa * 1e-6,
         .resistance_ohm = out.measurement.resistance_valid ? out.measurement.resistance_ohm : nan,
         .other_setpoint = other ? out.setpoint : nan,
         .other_measured = controlled_now});
    held(record_.states, out.state, cycle.time_s);
    for (unsigned i = 0; i < static_cast<unsigned>(LimitReason::count); ++i) {
      if ((out.limit_reasons >> i & 1U) != 0) {
        held(record_.limits, static_cast<LimitReason>(i), cycle.time_s);
      }
    }
    faults(record_.latched, out.latched, cycle.time_s);
    faults(record_.warnings, out.warnings, cycle.time_s);
  }

 private:
  template <class Key>
  void held(std::map<Key, Spans>& spans, Key key, double time_s) const {
    Spans& all = spans[key];
    if (all.empty() || time_s - all.back().second > gap_s_) {
      all.emplace_back(time_s, time_s);
    }
    all.back().second = time_s;
  }
  void faults(std::map<Fault, Spans>& spans, FaultSet set, double time_s) const {
    for (unsigned i = 0; !set.empty() && i < static_cast<unsigned>(Fault::count); ++i) {
      if (set.has(static_cast<Fault>(i))) {
        held(spans, static_cast<Fault>(i), time_s);
      }
    }
  }

  const Settings<double>& settings_;
  LoopRecord& record_;
  double gap_s_;  ///< shorter interruptions would not be visible
};

class Judge {
 public:
  Judge(const bench::ClosedLoopScenario& scenario, LoopRunResult& result)
      : settings_(scenario.settings),
        result_(result),
        steps_(scenario.settings.wire.nominal_stroke, scenario.settings.timing.period_s) {}

  void add(const bench::SimulatedCycle& cycle) {
    const Output<double>& out = cycle.output;
    const bool runs = out.state == DeviceState::running;
    steps_.add(cycle.time_s,
               runs ? wanted_strain(settings_, cycle.command.mode, cycle.command.setpoint) : nan,
               cycle.truth.strain,
               {wanted_strain(settings_, out.mode, out.setpoint), out.estimate.strain,
                out.limit_reasons | bits_of(out.warnings)});
    if (cycle.truth.hottest_K > result_.max_hottest_K) {
      result_.max_hottest_K = cycle.truth.hottest_K;
      result_.max_hottest_s = cycle.time_s;
    }
    result_.max_current_A = std::max(result_.max_current_A, cycle.truth.current_A);
    if (cycle.time_s > estimate_settles_s) {
      result_.max_estimate_error = std::max(
          result_.max_estimate_error, std::abs(cycle.output.estimate.strain - cycle.truth.strain));
    }
    const FaultSet fresh = cycle.output.latched - latched_;
    latched_ = cycle.output.latched;
    for (unsigned i = 0; !fresh.empty() && i < static_cast<unsigned>(Fault::count); ++i) {
      if (fresh.has(static_cast<Fault>(i))) {
        result_.faults.emplace_back(static_cast<Fault>(i), cycle.time_s);
      }
    }
  }
  void finish() {
    steps_.finish();
    result_.strain_steps = steps_.steps();
  }

 private:
  const Settings<double>& settings_;
  LoopRunResult& result_;
  report::StepJudge steps_;
  FaultSet latched_;
};

/// The log of the first wire's device, with the truth about both wires in additional columns.
class LoopFile {
 public:
  LoopFile(const std::string& path, const bench::ClosedLoopScenario& scenario)
      : file_(path, {"host-sim simulate", scenario.name}, columns(scenario.board),
              truths(scenario.pair.has_value())) {}

  void add(const bench::ClosedLoop& loop) {
    further_.clear();
    const hal::SimTruth& truth = loop.cycle().truth;
    append({truth.strain, truth.hottest_K, truth.current_A, truth.stress_Pa});
    if (const auto other = loop.other()) {
      append({other->strain, other->current_A, other->hottest_K});
    }
    file_.add(loop.cycle(), further_);
  }
  void commit() { file_.commit(); }

 private:
  static std::vector<text::DeviceColumn> columns(const hal::SimSetup& board) {
    std::vector<text::DeviceColumn> all =
        text::log_columns(board.reads_supply, board.reads_ambient, board.reads_driver);
    all.insert(all.end(), text::output_columns().begin(), text::output_columns().end());
    return all;
  }
  static std::vector<std::string> truths(bool pair) {
    std::vector<std::string> all{"strain_ref", "hottest_K", "true_current_A", "true_stress_Pa"};
    if (pair) {
      all.insert(all.end(), {"other_strain_ref", "other_current_A", "other_hottest_K"});
    }
    return all;
  }
  void append(std::initializer_list<double> values) {
    for (const double value : values) {
      further_ += ',';
      text::append_number(further_, value);
    }
  }

  text::DeviceTraceFile file_;
  std::string further_;
};

/// What a limit is set by, with its value; empty for what does not hold a wire back.
std::string cause_of(LimitReason reason, const Settings<double>& settings, FaultSet warnings) {
  const SoftLimits<double>& q = settings.limits;
  switch (reason) {
    case LimitReason::current:
      return fmt::format("limits.current_A, {:.4g} mA", 1e3 * q.current_A);
    case LimitReason::power:
      return fmt::format("limits.power_W, {:.4g} W", q.power_W);
    case LimitReason::temperature:
      return fmt::format(
          "{:.4g} °C: limits.temperature_degC, {:.4g}, less limits.hot_spot_K, {:.4g}",
          q.temperature_K - q.hot_spot_K - zero_degC_K, q.temperature_K - zero_degC_K,
          q.hot_spot_K);
    case LimitReason::strain:
      return fmt::format("limits.min_strain, {:.4g} %", 100 * q.min_strain);
    case LimitReason::stress:
      return fmt::format("limits.stress_Pa, {:.4g} MPa", 1e-6 * q.stress_Pa);
    case LimitReason::duty:
      return fmt::format("limits.duty, {:.4g}", q.duty);
    case LimitReason::supply:
      return "the voltage of the supply";
    case LimitReason::protection:
      return fmt::format("the warning {}", text::names_of(warnings));
    case LimitReason::min_current:
    case LimitReason::trajectory:
    case LimitReason::count:
      break;
  }
  return "";
}

bool acts(const report::StepFigures& step, LimitReason reason) {
  return (step.limits >> static_cast<unsigned>(reason) & 1U) != 0;
}

/// The limits that held a step, each on a line of its own.
std::string causes_of(const report::StepFigures& step, const Settings<double>& settings) {
  const FaultSet warnings = warnings_of(step.limits);
  std::string causes;
  for (unsigned i = 0; i < static_cast<unsigned>(LimitReason::count); ++i) {
    const auto reason = static_cast<LimitReason>(i);
    const std::string cause = acts(step, reason) ? cause_of(reason, settings, warnings) : "";
    causes += cause.empty() ? "" : (causes.empty() ? "\n  " : ";\n  ") + cause;
  }
  return causes;
}

/// Why a step ended outside of its band.
std::string reason_of(const report::StepFigures& step, const Settings<double>& settings,
                      const LoopRunResult& result) {
  const double end_s = step.from_s + step.seconds;
  // The step ends in the cycle that latches the fault.
  const double margin_s = 2 * settings.timing.period_s;
  for (const auto& [fault, time_s] : result.faults) {
    if (std::abs(time_s - end_s) < margin_s) {
      return fmt::format("ended by {};\n  see host-sim explain {}", fault_name(fault),
                         fault_name(fault));
    }
  }
  const double stroke = settings.wire.nominal_stroke;
  if (std::abs(step.held - step.to) > 1e-3 * stroke) {
    const bool at_min = step.to < step.held;
    return fmt::format("set-point held at {:.3f} % by\n  limits.{}_strain, {:.4g} %",
                       100 * step.held, at_min ? "min" : "max",
                       100 * (at_min ? settings.limits.min_strain : settings.limits.max_strain));
  }
  const std::string causes = causes_of(step, settings);
  if (!causes.empty() && step.to < step.end) {
    return fmt::format("held at {:.3f} % by{}", 100 * step.end, causes);
  }
  if (acts(step, LimitReason::min_current) && step.end < step.to) {
    return fmt::format("at {:.3f} % and still cooling, at the least current", 100 * step.end);
  }
  return std::abs(step.estimate - step.to) < 0.02 * stroke
             ? fmt::format("the estimate was wrong, {:.3f} %\n  where the wire was at {:.3f} %",
                           100 * step.estimate, 100 * step.end)
             : fmt::format("at {:.3f} % when it ended, and no limit held it", 100 * step.end);
}

}  // namespace

double wanted_strain(const Settings<double>& settings, Mode mode, double value) {
  if (mode == Mode::strain) {
    return value;
  }
  return mode == Mode::position
             ? settings.axis.zero_strain - value / settings.wire.geometry.length_m
             : nan;
}

std::vector<std::string> unreached(const bench::ClosedLoopScenario& scenario,
                                   const LoopRunResult& result) {
  std::vector<std::string> remarks;
  for (const report::StepFigures& step : result.strain_steps) {
    if (report::is_unreached(step)) {
      remarks.push_back(fmt::format("step at {:.3f} s, to {:.3f} %: {}", step.from_s, 100 * step.to,
                                    reason_of(step, scenario.settings, result)));
    }
  }
  return remarks;
}

LoopRunResult run_closed_loop(const bench::ClosedLoopScenario& scenario,
                              const LoopRunOptions& options) {
  LoopRunResult result;
  std::unique_ptr<LoopFile> file;
  if (!options.out.empty()) {
    file = std::make_unique<LoopFile>(options.out, scenario);
  }
  std::optional<Recorder> recorder;
  if (options.record) {
    recorder.emplace(scenario, result.record.emplace());
  }
  Judge judge(scenario, result);
  bench::ClosedLoop loop(scenario);
  const auto start = std::chrono::steady_clock::now();
  while (loop.step()) {
    judge.add(loop.cycle());
    if (recorder) {
      recorder->add(loop.cycle());
    }
    if (file) {
      file->add(loop);
    }
    ++result.steps;
  }
  judge.finish();
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
  result.elapsed_s = elapsed.count();
  result.duration_s =
      static_cast<double>(result.steps) * static_cast<double>(scenario.board.period_ns) * 1e-9;
  if (file) {
    file->commit();
  }
  return result;
}

std::string summary(const bench::ClosedLoopScenario& scenario, const LoopRunResult& result) {
  std::string text =
      fmt::format("{}: {} steps, {:.4g} s, {:.0f} times real time\n{}\n",
                  files::printable(scenario.name), result.steps, result.duration_s,
                  result.duration_s / result.elapsed_s, files::printable(scenario.note));
  text += fmt::format(
      "hottest point {:.1f} °C at {:.3f} s, greatest current {:.0f} mA, greatest "
      "error of the estimate {:.1f} % of the stroke\n",
      result.max_hottest_K - zero_degC_K, result.max_hottest_s, 1e3 * result.max_current_A,
      100 * result.max_estimate_error / scenario.settings.wire.nominal_stroke);
  for (const auto& [fault, time_s] : result.faults) {
    text += fmt::format("{:.3f} s: {}\n", time_s, fault_name(fault));
  }
  if (result.strain_steps.empty()) {
    return text;
  }
  text += report::steps_table(result.strain_steps).text() +
          "from and to in strain, overshoot and steady error in % of the nominal stroke\n";
  const std::vector<std::string> remarks = unreached(scenario, result);
  text += remarks.empty() ? "" : "Outside of ±2 % of the stroke at the end:\n";
  for (const std::string& remark : remarks) {
    text += remark + '\n';
  }
  return text;
}

}  // namespace smaservo::simulate
