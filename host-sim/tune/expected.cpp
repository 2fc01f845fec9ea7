#include "host-sim/tune/expected.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "firmware/device/device.hpp"
#include "host-sim/tune/bench.hpp"

namespace smaservo::tune {
namespace {

constexpr double contraction[] = {0.5, 0.85, 0.4, 0.15};
constexpr std::size_t step_count = std::size(contraction);
/// Band in which a step has settled, as a share of the nominal stroke.
constexpr double settled = 0.02;

/// The times at which the device is armed and the set-points change.
struct Plan {
  std::size_t arms;   ///< tick at which the device is armed
  std::size_t first;  ///< tick of the first step, when the device has armed
  std::size_t holds;  ///< ticks of each step
  double setpoint[step_count];

  std::size_t ticks() const { return begins(step_count); }
  std::size_t begins(std::size_t step) const { return first + step * holds; }
  double at(std::size_t tick, double rest) const {
    return tick < first ? rest : setpoint[(tick - first) / holds];
  }
};

Plan make_plan(const Proposal& p) {
  const Branches& b = p.branches;
  const double period_s = p.settings.timing.period_s;
  const double hold_s = std::min(1.0 + 2 * b.cooling_s, 120.0);
  Plan plan{static_cast<std::size_t>(0.2 / period_s),
            static_cast<std::size_t>(1.5 / period_s),
            static_cast<std::size_t>(hold_s / period_s),
            {}};
  for (std::size_t i = 0; i < step_count; ++i) {
    plan.setpoint[i] = b.rest_strain - contraction[i] * b.stroke();
  }
  return plan;
}

ExpectedRun run(const TunedPlant& plant, double believed_K, const Prepared<double>& prepared,
                const Plan& plan, double rest) {
  const Settings<double>& q = prepared.settings;
  const double dt_s = q.timing.period_s;
  TunedBench bench(plant, q.measurement.current_noise_A, q.measurement.voltage_noise_V);
  Device<double>::State device = Device<double>::start();
  ExpectedRun r{};
  double next_A = 0;
  Command<double> command{};
  DeviceState state = DeviceState::starting;
  for (std::size_t i = 0; i < plan.ticks(); ++i) {
    command.fresh = true;
    // Arming is refused while the observer is unsure, so the request is repeated.
    command.arm = plan.arms <= i && !(command.arm && state == DeviceState::ready);
    command.mode = Mode::strain;
    command.setpoint = plan.at(i, rest);
    Inputs<double> in = bench.inputs();
    in.ambient_K = believed_K;
    // The test of the cooling is suppressed: it would lengthen the wire for 0.2 s, which would
    // count as ripple of the control.
    device.monitor.wire.cooling.confirm();
    const Output<double> out = Device<double>::step(prepared, device, in, command, dt_s);
    state = out.state;
    if (plan.first <= i && state != DeviceState::running) {
      r.faults = r.faults | out.latched | out.blocks;
    }
    const double current_A = next_A;
    next_A = out.drive_current_A;
    bench.drive(current_A, dt_s);
    r.strain.push_back(bench.strain());
    r.temperature_K.push_back(bench.temperature_K());
    r.current_A.push_back(current_A);
  }
  return r;
}

StepResponse worse(const StepResponse& a, const StepResponse& b) {
  const double error =
      std::abs(a.steady_error) < std::abs(b.steady_error) ? b.steady_error : a.steady_error;
  return {a.from,
          a.to,
          a.begins_s,
          std::max(a.rise_s, b.rise_s),
          std::max(a.settling_s, b.settling_s),
          std::max(a.overshoot, b.overshoot),
          error,
          std::max(a.ripple, b.ripple),
          std::max(a.hottest_K, b.hottest_K)};
}

}  // namespace

StepResponse judge_step(const std::vector<double>& strain, std::size_t first, std::size_t last,
                        double from, double to, double period_s, double band) {
  StepResponse r{};
  r.from = from;
  r.to = to;
  r.begins_s = static_cast<double>(first) * period_s;
  const auto at = [&](std::size_t i) { return strain.begin() + static_cast<std::ptrdiff_t>(i); };
  const std::size_t tail = last - (last - first) * 3 / 10;
  const double end = std::accumulate(at(tail), at(last), 0.0) / static_cast<double>(last - tail);
  const auto [low, high] = std::minmax_element(at(tail), at(last));
  r.ripple = *high - *low;
  r.steady_error = end - to;
  const double begin = strain[first];
  const double way = end - begin;
  const auto share = [&](std::size_t i) { return (strain[i] - begin) / way; };
  std::size_t leaves = last, arrives = last;
  for (std::size_t i = first; i < last; ++i) {
    leaves = leaves == last && 0.1 <= share(i) ? i : leaves;
    arrives = arrives == last && 0.9 <= share(i) ? i : arrives;
    r.settling_s = band < std::abs(strain[i] - end) ? static_cast<double>(i + 1 - first) * period_s
                                                    : r.settling_s;
    r.overshoot = std::max(r.overshoot, (share(i) - 1) * std::abs(way));
  }
  r.rise_s = static_cast<double>(arrives - leaves) * period_s;
  return r;
}

ExpectedSteps expected_steps(const TuneTask& task, const Proposal& p,
                             const std::vector<TunedPlant>& plants,
                             const std::function<void(double)>& progress) {
  const Plan plan = make_plan(p);
  const Prepared<double> prepared = prepare(p.settings);
  const double period_s = p.settings.timing.period_s;
  ExpectedSteps all{period_s, {}, {}};
  for (std::size_t i = 0; i < plan.ticks(); ++i) {
    all.setpoint.push_back(plan.at(i, p.branches.rest_strain));
  }
  for (std::size_t m = 0; m < plants.size(); ++m) {
    ExpectedRun r = run(plants[m], task.plant.ambient_K, prepared, plan, p.branches.rest_strain);
    r.member = m;
    for (std::size_t i = 0; i < step_count; ++i) {
      const std::size_t first = plan.begins(i);
      const std::size_t last = first + plan.holds;
      const double from = i == 0 ? p.branches.rest_strain : plan.setpoint[i - 1];
      StepResponse s = judge_step(r.strain, first, last, from, plan.setpoint[i], period_s,
                                  settled * task.plant.wire.nominal_stroke);
      const auto at = [&](std::size_t k) {
        return r.temperature_K.begin() + static_cast<std::ptrdiff_t>(k);
      };
      s.hottest_K = *std::max_element(at(first), at(last));
      r.steps.push_back(s);
    }
    all.runs.push_back(std::move(r));
    progress(static_cast<double>(m + 1) / static_cast<double>(plants.size()));
  }
  return all;
}

int restless_wires(const ExpectedSteps& expected, const Settings<double>& settings) {
  const double still = 0.025 * settings.wire.nominal_stroke;
  const double lost = 0.2 * settings.wire.nominal_stroke;
  return static_cast<int>(std::ranges::count_if(expected.runs, [&](const ExpectedRun& r) {
    return !r.faults.empty() || std::ranges::any_of(r.steps, [&](const StepResponse& s) {
      return still < s.ripple || lost < std::abs(s.steady_error) ||
             settings.limits.temperature_K < s.hottest_K;
    });
  }));
}

std::vector<StepResponse> worst_steps(const ExpectedSteps& expected) {
  std::vector<StepResponse> worst = expected.runs.front().steps;
  for (const ExpectedRun& r : expected.runs) {
    for (std::size_t i = 0; i < worst.size(); ++i) {
      worst[i] = worse(worst[i], r.steps[i]);
    }
  }
  return worst;
}

}  // namespace smaservo::tune
