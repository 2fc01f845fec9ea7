#include "host-sim/evaluate/closed_loop/hottest.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <map>

#include "firmware/bench/closed_loop.hpp"
#include "firmware/text/device_names.hpp"
#include "host-sim/parallel.hpp"
#include "model/files/text_table.hpp"

namespace smaservo::evaluate {
namespace {

constexpr std::size_t max_named = 20;

double quantile(const std::vector<HottestRun>& sorted, double share) {
  const auto last = static_cast<double>(sorted.size() - 1);
  return sorted[static_cast<std::size_t>(std::lround(share * last))].above_limit_K;
}

/// Counts the scenarios of a class and finds the worst one.
struct Tally {
  int runs = 0, violations = 0, tripped = 0;
  double worst_K = -std::numeric_limits<double>::infinity();
  std::uint64_t worst_seed = 0;

  void add(const HottestRun& run) {
    ++runs;
    violations += run.violates() ? 1 : 0;
    tripped += run.first_cause != Fault::none ? 1 : 0;
    if (run.above_limit_K > worst_K) {
      worst_K = run.above_limit_K;
      worst_seed = run.seed;
    }
  }
};

void add_line(files::TextTable& table, const std::string& what, const Tally& t) {
  table.add({what, t.runs, {t.violations, t.violations > 0}, t.worst_K, t.worst_seed, t.tripped});
}

/// Adds a line for each class.
void add_lines(files::TextTable& table, const std::vector<HottestRun>& runs, std::string_view kind,
               std::string_view (*name)(const HottestRun&)) {
  std::map<std::string_view, Tally> classes;
  for (const HottestRun& run : runs) {
    classes[name(run)].add(run);
  }
  for (const auto& [what, tally] : classes) {
    add_line(table, fmt::format("{}: {}", kind, what), tally);
  }
}

files::TextTable classes(const std::vector<HottestRun>& runs, const Tally& all) {
  files::TextTable table({{""},
                          {"scenarios", "{}"},
                          {fmt::format("above {:g} K", hottest_allowed_K), "{}"},
                          {"highest, K", "{:.1f}"},
                          {"its seed", "{}"},
                          {"trip", "{}"}});
  add_line(table, "all", all);
  add_lines(table, runs, "mode", [](const HottestRun& r) { return text::mode_name(r.mode); });
  add_lines(table, runs, "set-points", [](const HottestRun& r) {
    return std::string_view(r.beyond ? "beyond the limits" : "within the limits");
  });
  add_lines(table, runs, "air", [](const HottestRun& r) { return random_air_name(r.air); });
  add_lines(table, runs, "trouble",
            [](const HottestRun& r) { return random_trouble_name(r.trouble); });
  return table;
}

}  // namespace

HottestRun run_hottest(const RandomScenario& scenario) {
  bench::ClosedLoop loop(scenario.loop);
  HottestRun run{scenario.loop.seed,
                 scenario.mode,
                 scenario.air,
                 scenario.trouble,
                 scenario.beyond,
                 scenario.loop.duration_s,
                 -std::numeric_limits<double>::infinity(),
                 0,
                 Fault::none,
                 std::numeric_limits<double>::infinity(),
                 0,
                 false,
                 false};
  double before_s = 0;
  double since_s = std::numeric_limits<double>::infinity();
  const double limit_K = scenario.loop.settings.limits.temperature_K;
  while (loop.step()) {
    const bench::SimulatedCycle& cycle = loop.cycle();
    if (cycle.truth.hottest_K - limit_K > run.above_limit_K) {
      run.above_limit_K = cycle.truth.hottest_K - limit_K;
      run.at_s = cycle.time_s;
    }
    if (run.first_cause == Fault::none && cycle.output.first_cause != Fault::none) {
      run.first_cause = cycle.output.first_cause;
      run.tripped_s = cycle.time_s;
    }
    // A fault while the point is too hot, or up to hottest_answered_s after it first was, counts as
    // an answer.
    if (cycle.truth.hottest_K - limit_K > hottest_allowed_K) {
      run.over_s += cycle.time_s - before_s;
      since_s = std::min(since_s, cycle.time_s);
    }
    if (cycle.output.state == DeviceState::fault) {
      since_s = std::numeric_limits<double>::infinity();
    }
    run.unanswered = run.unanswered || cycle.time_s - since_s > hottest_answered_s;
    before_s = cycle.time_s;
  }
  run.halved = scenario.halved_s <= run.at_s;
  return run;
}

std::vector<HottestRun> run_hottest(const std::vector<CalibratedUnit>& units, std::uint64_t seed,
                                    int count, int threads,
                                    const std::function<void(std::size_t)>& done) {
  std::vector<HottestRun> runs(static_cast<std::size_t>(count));
  parallel(
      runs.size(), threads,
      [&](std::size_t i) { runs[i] = run_hottest(random_scenario(units, seed + i)); }, done);
  return runs;
}

std::string hottest_markdown(const std::vector<HottestRun>& runs) {
  Tally all;
  int harmless = 0;
  int far = 0;
  int far_halved = 0;
  int unanswered = 0;
  double over_s = 0;
  int false_trips = 0;
  std::map<std::string_view, int> causes;
  for (const HottestRun& run : runs) {
    all.add(run);
    harmless += run.harmless() ? 1 : 0;
    const bool is_far = run.above_limit_K > hottest_far_K;
    far += is_far ? 1 : 0;
    far_halved += is_far && run.halved ? 1 : 0;
    unanswered += run.unanswered ? 1 : 0;
    over_s += run.over_s;
    false_trips += run.false_alarm() ? 1 : 0;
    ++causes[fault_name(run.first_cause)];
  }
  std::vector<HottestRun> sorted = runs;
  std::ranges::sort(sorted, {}, &HottestRun::above_limit_K);
  std::string text = fmt::format(
      "True hottest point above `limits.temperature_K` in {} random scenarios of 20 to 600 s: "
      "{} above it by more than {:g} K, {:.1f} s in all, {} of these in no fault {:g} s later; "
      "{} by more than {:g} K, of which {} after the draught had halved within a second; "
      "median {:.1f} K, 90 % {:.1f}, 99 % {:.1f}, highest {:.1f}. "
      "In {} scenarios without any disturbance {} ended with a fault other than "
      "`following_error`.\n\n{}",
      all.runs, all.violations, hottest_allowed_K, over_s, unanswered, hottest_answered_s, far,
      hottest_far_K, far_halved, quantile(sorted, 0.5), quantile(sorted, 0.9),
      quantile(sorted, 0.99), all.worst_K, harmless, false_trips, classes(runs, all).markdown());
  text += "\nFirst trips:";
  for (const auto& [name, count] : causes) {
    text += fmt::format(" {} {}{}", name, count, name == causes.rbegin()->first ? ".\n" : ",");
  }
  std::vector<HottestRun> worst(
      sorted.rbegin(),
      sorted.rbegin() + static_cast<std::ptrdiff_t>(std::min(max_named, sorted.size())));
  std::erase_if(worst, [](const HottestRun& r) { return !r.violates(); });
  for (const HottestRun& r : worst) {
    text += fmt::format("\n- seed {}: {:.1f} K at {:.2f} s, {}, {}, {}{}{}", r.seed,
                        r.above_limit_K, r.at_s, text::mode_name(r.mode), random_air_name(r.air),
                        random_trouble_name(r.trouble), r.beyond ? ", beyond" : "",
                        r.halved ? ", draught halved" : "");
  }
  return text + (worst.empty() ? "" : "\n");
}

}  // namespace smaservo::evaluate
