#include "host-sim/tune/tune.hpp"

#include <algorithm>
#include <fmt/format.h>

#include "firmware/text/device_names.hpp"
#include "host-sim/tune/linear/uncertainty.hpp"
#include "host-sim/tune/output/rounding.hpp"

namespace smaservo::tune {
namespace {

/// Number of uncertain wires on which the steps are simulated.
constexpr int expected_members = 12;
/// Factors of the dead band that are tried, 1, 2, 4 and 8 at most, and the share of the whole time
/// that they take then.
constexpr double most_tries = 4;
constexpr double by_steps = 0.9;

/// Chooses the smallest dead band with which the number of restless wires is least.
void try_dead_bands(Tuned& t, const std::function<void(double)>& progress) {
  const std::vector<TunedPlant> plants =
      uncertain_plants(t.task.plant, expected_members, t.task.seed);
  Proposal tried = t.proposal;
  const double min = tried.settings.strain.dead_band;
  int fewest = expected_members + 1;
  double tries = 0;
  for (double factor = 1; factor <= 8 && 0 < fewest; factor *= 2) {
    tried.settings.strain.dead_band = rounded_up(factor * min);
    ExpectedSteps expected = expected_steps(t.task, tried, plants, [&](double share) {
      progress(by_steps * (tries + share) / most_tries);
    });
    ++tries;
    const int restless = restless_wires(expected, tried.settings);
    if (restless < fewest) {
      fewest = restless;
      t.proposal.settings = tried.settings;
      t.expected = std::move(expected);
    }
  }
  if (0 < fewest) {
    t.warnings.push_back(
        fmt::format("{} of {} uncertain wires keep moving by 2.5 % of the stroke, are "
                    "off by 20 % of it, overheat, trip or do not arm",
                    fewest, expected_members));
  }
  FaultSet faults;
  for (const ExpectedRun& r : t.expected.runs) {
    faults = faults | r.faults;
  }
  if (!faults.empty()) {
    t.warnings.push_back(fmt::format("faults of the uncertain wires: {}", text::names_of(faults)));
  }
}

void warn(Tuned& t) {
  const SoftLimits<double>& q = t.proposal.settings.limits;
  const double max_Pa = std::max(t.task.plant.load.low_Pa, t.proposal.branches.hot_Pa);
  if (0.9 * q.stress_Pa < max_Pa) {
    t.warnings.push_back(
        fmt::format("the load reaches {:.4g} MPa, within a tenth of the limit of {:.4g} MPa, where "
                    "the device reduces heat",
                    1e-6 * max_Pa, 1e-6 * q.stress_Pa));
  }
  const auto off = std::ranges::count_if(t.relays, [](const RelayCheck& c) { return !agrees(c); });
  if (0 < off) {
    t.warnings.push_back(
        fmt::format("{} of {} relay tests do not agree with the linearisation within a factor {}",
                    off, t.relays.size(), relay_factor));
  }
}

}  // namespace

Tuned tune(const std::string& wire, const std::string& based_on, const TuneTask& task,
           const std::function<void(double)>& progress) {
  Tuned t{wire, based_on, task, propose(task), {}, {}, {}, {}, {}};
  try_dead_bands(t, progress);
  progress(by_steps);
  const auto possible = [&](LoopName name) {
    return t.proposal.loops[static_cast<std::size_t>(name)].possible;
  };
  t.chosen = chosen_settings(t.proposal.settings, possible(LoopName::resistance),
                             possible(LoopName::force));
  t.relays = relay_checks(task, t.proposal);
  t.worst = worst_steps(t.expected);
  warn(t);
  return t;
}

}  // namespace smaservo::tune
