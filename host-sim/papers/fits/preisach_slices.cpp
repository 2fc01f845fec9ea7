#include "host-sim/papers/fits/preisach_slices.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

#include "host-sim/identify/runs/steady_load.hpp"
#include "model/files/error.hpp"
#include "model/units.hpp"

namespace smaservo::fits {
namespace {

constexpr double smallest_reversal_K = 0.5;
constexpr double same_stress_Pa = 3e6;
constexpr std::size_t fewest_curves = 5;

[[noreturn]] void fail(const identify::Run& run, const std::string& what) {
  throw files::UserError(fmt::format("{}: {}", run.name, what));
}

double checked_stress_Pa(const identify::Run& run) {
  if (run.kind != identify::RunKind::bath || run.strain.empty()) {
    fail(run,
         fmt::format("is a {} run{}; the Preisach model is identified from strain over "
                     "temperature in a bath",
                     identify::name_of(run.kind), run.strain.empty() ? " without strain" : ""));
  }
  const double middle_Pa = identify::quantile(run.stress_Pa, 0.5);
  const double low_Pa = identify::quantile(run.stress_Pa, 0.05);
  const double high_Pa = identify::quantile(run.stress_Pa, 0.95);
  if (low_Pa < middle_Pa - same_stress_Pa || high_Pa > middle_Pa + same_stress_Pa) {
    fail(run,
         fmt::format("its stress goes from {:.1f} to {:.1f} MPa; reversal curves need a constant "
                     "one, within {:.0f} MPa",
                     1e-6 * low_Pa, 1e-6 * high_Pa, 1e-6 * same_stress_Pa));
  }
  const auto [coldest, hottest] = std::ranges::minmax(run.temperature_K);
  const double start = (run.temperature_K.front() - coldest) / (hottest - coldest);
  if (!(start < 0.1 || start > 0.9)) {
    fail(run, fmt::format("begins at {:.1f} °C, in the middle of its range, where nobody knows the "
                          "wire's history; begin at the hottest or the coldest point",
                          run.temperature_K.front() - zero_degC_K));
  }
  return middle_Pa;
}

/// The number of different temperatures, in whole kelvins, from which the wire was cooled in
/// mid-transformation.
std::size_t reversal_count(const PreisachSlice& slice) {
  const double stroke = slice.longest - slice.shortest;
  std::vector<long> tops;
  for (const identify::Run* run : slice.runs) {
    const std::vector<double> T = steady_K(run->temperature_K);
    bool heats = false;
    for (std::size_t i = 1; i < T.size(); ++i) {
      const double converted = (slice.longest - run->strain[i - 1]) / stroke;
      if (heats && T[i] < T[i - 1] && converted > 0.02 && converted < 0.98) {
        tops.push_back(std::lround(T[i - 1]));
      }
      heats = T[i] > T[i - 1] || (heats && !(T[i] < T[i - 1]));
    }
  }
  std::ranges::sort(tops);
  const auto repeated = std::ranges::unique(tops);
  return tops.size() - repeated.size();
}

void require_reversal_curves(const std::vector<PreisachSlice>& slices) {
  for (const PreisachSlice& slice : slices) {
    const std::size_t count = reversal_count(slice);
    if (count < fewest_curves) {
      throw files::UserError(fmt::format(
          "{}: {} reversal curves at {:.0f} MPa; the Preisach model needs at least {}, better 20: "
          "heat to another temperature within the transformation each time and cool down fully",
          slice.runs.front()->name, count, 1e-6 * slice.stress_Pa, fewest_curves));
    }
  }
}

}  // namespace

std::vector<double> steady_K(const std::vector<double>& temperature_K) {
  std::vector<double> steady;
  double reached_K = temperature_K.front();
  bool heats = false;
  bool moving = false;
  for (const double T : temperature_K) {
    const double ahead_K = heats ? T - reached_K : reached_K - T;
    if (!moving && std::abs(T - reached_K) > smallest_reversal_K) {
      moving = true;
      heats = T > reached_K;
      reached_K = T;
    } else if (moving && ahead_K < -smallest_reversal_K) {
      heats = !heats;
      reached_K = T;
    } else if (moving && ahead_K > 0) {
      reached_K = T;
    }
    steady.push_back(reached_K);
  }
  return steady;
}

std::vector<PreisachSlice> preisach_slices(const std::vector<identify::Run>& runs,
                                           std::size_t max) {
  if (runs.empty()) {
    throw files::UserError("no run; the Preisach model needs reversal curves in a bath");
  }
  std::vector<PreisachSlice> slices;
  for (const identify::Run& run : runs) {
    const double stress_Pa = checked_stress_Pa(run);
    const auto [shortest, longest] = std::ranges::minmax(run.strain);
    const auto same = std::ranges::find_if(slices, [&](const PreisachSlice& slice) {
      return std::abs(slice.stress_Pa - stress_Pa) <= same_stress_Pa;
    });
    if (same == slices.end()) {
      slices.push_back({stress_Pa, {&run}, shortest, longest});
    } else {
      same->runs.push_back(&run);
      same->shortest = std::min(same->shortest, shortest);
      same->longest = std::max(same->longest, longest);
    }
  }
  std::ranges::sort(slices, {}, &PreisachSlice::stress_Pa);
  if (slices.size() > max) {
    throw files::UserError(
        fmt::format("{} stresses; the Preisach model holds up to {}", slices.size(), max));
  }
  require_reversal_curves(slices);
  return slices;
}

}  // namespace smaservo::fits
