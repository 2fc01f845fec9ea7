#include "host-sim/papers/compare/compare.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <optional>
#include <utility>

#include "host-sim/identify/fit/fit.hpp"
#include "model/files/error.hpp"
#include "model/wire/plant.hpp"

namespace smaservo::compare {
namespace {

/// The share of the time that has passed when the work on a system begins, as it was on three runs
/// of host-sim/traces; "fit" is that of ihyp, which several systems use.
double usual_share(std::string_view system) {
  struct Usual {
    std::string_view system;
    double share;
  };
  constexpr Usual all[] = {{"Duhem", 0.01},    {"Liang-Rogers", 0.08}, {"fit", 0.11},
                           {"Preisach", 0.97}, {"ihyp", 0.99},         {"ihyp observer", 0.99},
                           {"GRU", 0.99},      {"tests", 0.99}};
  const auto* const found = std::ranges::find(all, system, &Usual::system);
  return found == std::end(all) ? 0 : found->share;
}

void require_usable(const identify::Run& run) {
  if (run.kind != identify::RunKind::joule && run.kind != identify::RunKind::bath) {
    throw files::UserError(
        fmt::format("{}: is a {} run; compare takes runs of Joule heating or in a bath", run.name,
                    identify::name_of(run.kind)));
  }
  if (run.strain.empty()) {
    throw files::UserError(
        fmt::format("{}: has no strain_ref or displacement, which compare needs", run.name));
  }
}

/// The wire that `identify` finds from the runs. Throws UserError.
IdentifiedWire identified(const files::WireDescription& from,
                          const std::vector<identify::Run>& training, int threads,
                          const Progress& progress) {
  const double begin = usual_share("fit");
  const double end = usual_share("Preisach");
  identify::FitOptions options;
  options.threads = threads;
  options.proceed = [&](const identify::FitProgress& at) {
    progress(fmt::format("ihyp, {}", at.stage), begin + at.share * (end - begin));
    return true;
  };
  const identify::FitResult fit = identify::fit_wire(from.wire, training, options);
  IdentifiedWire found{fit.wire, static_cast<int>(fit.parameters.size()), {}, 0};
  for (const identify::FittedRun& run : fit.runs) {
    found.ambient_K.push_back(run.circumstances.ambient_K);
    found.usual_ambient_K += run.circumstances.ambient_K / static_cast<double>(fit.runs.size());
  }
  return found;
}

/// Identifies systems one after the other.
class Systems {
 public:
  explicit Systems(const Progress& progress) : progress_(progress) {}

  template <class Identify>
  void add(const char* name, Identify identify) {
    progress_(name, usual_share(name));
    Compared one;
    try {
      one.system = identify();
    } catch (const files::UserError& error) {
      one.system = {name, "", 0, fmt::format("not identified: {}", error.what()), {}};
    }
    all.push_back(std::move(one));
  }

  std::vector<Compared> all;

 private:
  const Progress& progress_;
};

/// Moves a run whose strain has its own zero, so that its longest wire is as long as `from` at rest
/// under that load. Otherwise runs of different loads would contradict each other.
identify::Run placed(identify::Run run, const Wire<double>& from) {
  if (identify::zero_known(run.strain)) {
    return run;
  }
  using Model = Plant<ThreePhase<double>>;
  const auto longest = std::ranges::max_element(run.strain);
  const auto row = static_cast<std::size_t>(longest - run.strain.begin());
  const double air_K = run.ambient_K.empty() ? room_K : run.ambient_K.front();
  const Drive<double> there{run.kind == identify::RunKind::bath ? run.temperature_K[row] : air_K,
                            run.stress_Pa[row]};
  const Model::Params params = plant_params(from);
  const double shift = Model::strain(params, Model::rest(params, there)) - *longest;
  for (double& strain : run.strain) {
    strain += shift;
  }
  return run;
}

std::vector<Compared> identify_all(const files::WireDescription& from, const Comparison& runs,
                                   int threads, const Progress& progress,
                                   const std::optional<gru::Network>& network) {
  const std::vector<identify::Run>& measured = runs.training;
  std::vector<identify::Run> training;
  training.reserve(measured.size());
  for (const identify::Run& run : measured) {
    training.push_back(placed(run, from.wire));
  }
  Systems systems(progress);
  systems.add("one line", [&] { return one_line(training); });
  systems.add("polynomial", [&] { return polynomial(training); });
  systems.add("two lines", [&] { return two_lines(training); });
  systems.add("stress-strain-resistance", [&] { return stress_strain_resistance(training); });
  systems.add("Duhem", [&] { return duhem(from.wire, training, threads); });
  systems.add("Liang-Rogers", [&] { return liang_rogers(from.wire, training, threads); });
  std::optional<IdentifiedWire> own;
  std::string reason;
  try {
    own = identified(from, measured, threads, progress);  // the fit finds the zeros by itself
  } catch (const files::UserError& error) {
    reason = error.what();
  }
  const auto with_own = [&](auto make) {
    if (!own) {
      throw files::UserError(reason);
    }
    return make(*own);
  };
  systems.add("Preisach", [&] {
    return with_own([&](const IdentifiedWire& wire) { return preisach(wire, training); });
  });
  systems.add("ihyp", [&] { return with_own(ihyp_alone); });
  systems.add("ihyp observer", [&] { return with_own(ihyp_observer); });
  if (network) {
    systems.add("GRU", [&] { return recurrent_network(*network, measured, runs.tests); });
  }
  return systems.all;
}

/// The median of the differences that are numbers; 0 if there are none.
double median_difference(const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<double> differences;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (std::isfinite(a[i] - b[i])) {
      differences.push_back(a[i] - b[i]);
    }
  }
  if (differences.empty()) {
    return 0;
  }
  const auto middle = differences.begin() + static_cast<std::ptrdiff_t>(differences.size() / 2);
  std::ranges::nth_element(differences, middle);
  return *middle;
}

using Column = std::vector<double> identify::Run::*;

/// The share of a test's rows, among those that are numbers, that lie outside of all training rows
/// by more than `margin(value)`.
template <class Margin>
double share_beyond(const identify::Run& test, const std::vector<identify::Run>& training,
                    Column column, Margin margin) {
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  for (const identify::Run& run : training) {
    for (const double x : run.*column) {
      low = x < low ? x : low;
      high = high < x ? x : high;
    }
  }
  double rows = 0;
  double outside = 0;
  for (const double x : test.*column) {
    rows += std::isfinite(x) ? 1 : 0;
    outside += x < low - margin(low) || high + margin(high) < x ? 1 : 0;
  }
  return rows > 0 && low <= high ? outside / rows : 0;
}

Beyond beyond(const identify::Run& test, const std::vector<identify::Run>& training) {
  return {share_beyond(test, training, &identify::Run::stress_Pa, [](double) { return 2e6; }),
          share_beyond(test, training, &identify::Run::resistance_ohm,
                       [](double ohm) { return 0.002 * ohm; })};
}

void test(Compared& one, const Comparison& comparison) {
  double elapsed_s = 0;
  double rows = 0;
  for (std::size_t t = 0; t < comparison.tests.size(); ++t) {
    const identify::Run& run = comparison.tests[t];
    SystemRun result;
    const auto start = std::chrono::steady_clock::now();
    result.strain = one.system.strain(run);
    const auto stop = std::chrono::steady_clock::now();
    const double zero = comparison.free_zero[t] ? median_difference(result.strain, run.strain) : 0;
    for (std::size_t i = 0; i < run.strain.size(); ++i) {
      result.strain[i] -= zero;
      const double error = result.strain[i] - run.strain[i];
      if (std::isfinite(error)) {
        result.error.add(100 * error / comparison.nominal_stroke);
      }
    }
    if (result.error.count() > 0) {
      elapsed_s += std::chrono::duration<double>(stop - start).count();
      rows += static_cast<double>(run.strain.size());
    }
    one.error.add(result.error);
    one.runs.push_back(std::move(result));
  }
  one.step_s = rows > 0 ? elapsed_s / rows : 0;
}

}  // namespace

Comparison compare(const files::WireDescription& from, std::vector<identify::Run> training,
                   std::vector<identify::Run> tests, int threads, const Progress& progress,
                   const std::optional<gru::Network>& network) {
  Comparison comparison{
      from.name, from.wire.nominal_stroke, std::move(training), std::move(tests), {}, {}, {}};
  for (const std::vector<identify::Run>* runs : {&comparison.training, &comparison.tests}) {
    std::ranges::for_each(*runs, require_usable);
  }
  for (const identify::Run& run : comparison.tests) {
    comparison.free_zero.push_back(!identify::zero_known(run.strain));
    comparison.beyond.push_back(beyond(run, comparison.training));
  }
  comparison.systems = identify_all(from, comparison, threads, progress, network);
  progress("tests", usual_share("tests"));
  bool any = false;
  for (Compared& one : comparison.systems) {
    if (one.system.strain) {
      any = true;
      test(one, comparison);
    }
  }
  if (!any) {
    throw files::UserError(
        fmt::format("no system could be identified; {}", comparison.systems.front().system.remark));
  }
  return comparison;
}

}  // namespace smaservo::compare
