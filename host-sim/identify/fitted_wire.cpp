#include "host-sim/identify/fitted_wire.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <limits>
#include <map>

#include "model/files/error.hpp"
#include "model/files/message.hpp"
#include "model/units.hpp"

namespace smaservo::identify {
namespace {

constexpr double max_strain = 0.15;
constexpr double max_resistance = 0.10;
constexpr double max_power = 0.5;
constexpr double max_stress_Pa = 100e6;

double largest_of(const std::vector<double>& values) {
  double largest = 0;
  for (const double value : values) {
    largest = std::isnan(value) ? largest : std::max(largest, value);
  }
  return largest;
}

/// The error of a run relative to what a fit may leave; above 1 the run is not explained.
double unexplained(const FittedRun& run) {
  const double share = run.kind == RunKind::calorimetry ? run.power.rms / max_power
                       : run.kind == RunKind::imposed   ? run.stress_Pa.rms / max_stress_Pa
                       : run.strain.count > 0           ? run.strain.rms / max_strain
                                                        : run.resistance.rms / max_resistance;
  return std::isnan(share) ? std::numeric_limits<double>::infinity() : share;
}

std::string deviation_text(const FittedRun& run) {
  if (run.kind == RunKind::calorimetry) {
    return fmt::format("heat flow by {:.0f} % of its greatest", 100 * run.power.rms);
  }
  if (run.kind == RunKind::imposed) {
    return fmt::format("stress by {:.0f} MPa", 1e-6 * run.stress_Pa.rms);
  }
  return run.strain.count > 0
             ? fmt::format("strain by {:.1f} % of the nominal stroke", 100 * run.strain.rms)
             : fmt::format("resistance by {:.1f} %", 100 * run.resistance.rms);
}

/// The standard deviation of measured values for which the model has a value, too.
double spread(const std::vector<double>& model, const std::vector<double>& measured) {
  double sum = 0, squares = 0, count = 0;
  for (std::size_t i = 0; i < model.size(); ++i) {
    if (!std::isnan(model[i] - measured[i])) {
      sum += measured[i];
      squares += measured[i] * measured[i];
      ++count;
    }
  }
  return count > 0 ? std::sqrt(std::max(0.0, squares / count - sum * sum / (count * count))) : 0;
}

double difference(const std::vector<double>& model, const std::vector<double>& measured) {
  double squares = 0, count = 0;
  for (std::size_t i = 0; i < model.size(); ++i) {
    const double d = model[i] - measured[i];
    squares += std::isnan(d) ? 0 : d * d;
    count += std::isnan(d) ? 0 : 1;
  }
  return count > 0 ? std::sqrt(squares / count) : 0;
}

/// Refuses a fit that is farther from a run than the run's own mean, if the run moves at all.
void check_better_than_mean(const FittedRun& run) {
  constexpr double min_strain = 0.003, min_resistance = 0.02;
  struct Channel {
    const char* name;
    const std::vector<double>&model, &measured;
    double min;
  };
  const bool calorimetry = run.kind == RunKind::calorimetry;
  const double ohm = run.resistance_measured.empty() ? 0 : largest_of(run.resistance_measured);
  for (const Channel& channel :
       {Channel{calorimetry ? "heat flow" : "strain", run.strain_model, run.strain_measured,
                calorimetry ? 0 : min_strain / 4},
        Channel{"resistance", run.resistance_model, run.resistance_measured,
                min_resistance / 4 * ohm},
        Channel{"stress", run.stress_model_Pa, run.stress_measured_Pa, 0}}) {
    if (channel.measured.empty() || (calorimetry && &channel.model != &run.strain_model)) {
      continue;
    }
    const double own = spread(channel.model, channel.measured);
    if (own > channel.min && difference(channel.model, channel.measured) > own) {
      throw files::UserError(fmt::format(
          "{}: the fitted model explains nothing of its {}: it is further from what was measured "
          "than the mean of that; is it this wire, with the right signs, units and columns?",
          run.name, channel.name));
    }
  }
}

void check_explained(const FitResult& fit) {
  std::vector<FittedRun> runs = fit.runs;
  std::ranges::sort(runs, {}, unexplained);
  if (unexplained(runs[(runs.size() - 1) / 2]) > 1) {
    throw files::UserError(
        fmt::format("{}: the fitted model misses its {} (RMS){}; is it this wire, with the right "
                    "units, length, load and columns?",
                    runs.back().name, deviation_text(runs.back()),
                    fit.interrupted ? "; the fit was interrupted too early" : ""));
  }
  if (!fit.interrupted) {
    std::ranges::for_each(fit.runs, check_better_than_mean);
  }
}

void check_valid(const files::WireDescription& wire) {
  try {
    files::parse_wire(files::to_toml(wire), wire.name);
  } catch (const files::ConfigError& error) {
    throw files::UserError(fmt::format("the runs lead to an impossible wire: {}", error.what()));
  }
}

std::string file_names(const FitResult& fit) {
  std::string text;
  for (const FittedRun& run : fit.runs) {
    text += (text.empty() ? "" : ", ") + file_name(run.name);
  }
  return text;
}

bool stands_above(std::string_view path, std::string_view key) {
  return key == path || (key.starts_with(path) && key[path.size()] == '.');
}

/// The source that applies to a key: its own, or that of the nearest table above.
std::string inherited(const files::WireDescription& from, std::string_view key) {
  std::string text;
  std::size_t longest = 0;
  for (const auto& [path, source] : from.sources) {
    if (stands_above(path, key) && path.size() >= longest) {
      longest = path.size();
      text = source;
    }
  }
  return text;
}

using Groups = std::map<std::string, std::vector<const FittedParameter*>>;

Groups grouped(const FitResult& fit) {
  Groups groups;
  for (const FittedParameter& fitted : fit.parameters) {
    groups[group_of(fitted.parameter.key)].push_back(&fitted);
  }
  return groups;
}

std::string source_of(const std::string& group, const Groups::mapped_type& parameters,
                      const files::WireDescription& from, const FitResult& fit) {
  std::vector<std::string> found, kept;
  for (const FittedParameter* fitted : parameters) {
    const FitParameter& parameter = fitted->parameter;
    const std::string name = parameter.key.substr(group.size() + 1);
    if (!fitted->determined) {
      kept.push_back(name);
      continue;
    }
    found.push_back(moved_text(*fitted, name));
  }
  const std::string runs =
      file_names(fit) + (fit.interrupted  ? " (interrupted before it was finished)"
                         : !fit.converged ? " (not converged)"
                                          : "");
  const std::string kept_from =
      from.name + (fit.moved_K != 0 && is_of_process(group)
                       ? fmt::format(" with its transitions moved by {:.1f} K", fit.moved_K)
                       : "");
  if (found.empty()) {
    const std::string before = inherited(from, group);
    return fmt::format("not determined by {}, kept from {}{}{}", runs, kept_from,
                       before.empty() ? "" : ": ", before);
  }
  std::string text = fmt::format("identified from {}; {}", runs, fmt::join(found, ", "));
  if (!kept.empty()) {
    text += fmt::format("; not determined by the data, kept from {}: {}", kept_from,
                        fmt::join(kept, ", "));
  }
  return text;
}

/// Whether the fit replaces the values that this source describes.
bool replaced(const std::string& path, const Groups& groups) {
  for (const auto& [group, parameters] : groups) {
    // A source of the whole wire still applies to keys that no fit changes.
    if ((path != "wire" && stands_above(path, group)) ||
        (is_of_process(path) && stands_above(group, path))) {
      return true;
    }
    for (const FittedParameter* fitted : parameters) {
      const std::string_view key = fitted->parameter.key;
      const bool scales = key == "wire.martensite.resistivity" && path == "wire.resistance";
      if (fitted->determined && (key.starts_with(path) || scales)) {
        return true;
      }
    }
  }
  return false;
}

/// The source of the model's structure, which the fit may have changed.
std::string structure_source(bool changed, const std::string& before, const FitResult& fit) {
  return changed ? fmt::format("chosen by the fit to {}", file_names(fit)) : before;
}

}  // namespace

std::string file_name(const std::string& path) {
  return files::printable(std::filesystem::path(path).filename().string());
}

std::string group_of(std::string_view key) {
  return std::string(key.substr(0, key.rfind('.')));
}

Figure figure(const FittedParameter& fitted) {
  const FitParameter& p = fitted.parameter;
  const double zero = p.unit == "degC" ? zero_degC_K : 0;
  const auto deviation = [&](double value, double sd) {
    switch (p.form) {
      case Form::sum:
        return sd / p.scale;
      case Form::factor:
        return std::abs(value) * sd / p.scale;
      case Form::share:
        return (p.most - p.least) * p.share_of(value) * (1 - p.share_of(value)) * sd / p.scale;
    }
    return 0.0;
  };
  return {(fitted.value - zero) / p.scale, deviation(fitted.value, fitted.sd),
          (p.prior - zero) / p.scale, deviation(p.prior, p.sd)};
}

std::string with_deviation(double value, double sd) {
  if (!(sd > 0)) {
    return fmt::format("{:.4g}", value);
  }
  const int power = static_cast<int>(std::floor(std::log10(sd)));
  const int decimals = std::clamp(1 - power, 0, 12);
  const bool nothing = std::abs(value) < 0.5 * std::pow(10, -decimals);  // avoids "-0.0"
  return fmt::format("{:.{}f} ± {:.{}f}", nothing ? 0.0 : value, decimals, sd, decimals);
}

std::string moved_text(const FittedParameter& fitted, std::string_view name) {
  const Figure f = figure(fitted);
  const std::string& unit = fitted.parameter.unit;
  return fmt::format("{} from {:.4g} to {}{}{}", name, f.prior, with_deviation(f.value, f.sd),
                     unit.empty() ? "" : " ", unit);
}

files::WireDescription fitted_wire(const files::WireDescription& from, const FitResult& fit,
                                   const std::string& name) {
  check_explained(fit);
  const Groups groups = grouped(fit);
  std::map<std::string, std::string> sources;
  for (const auto& [path, text] : from.sources) {
    if (!replaced(path, groups)) {
      sources[path] = text;
    }
  }
  for (const auto& [group, parameters] : groups) {
    sources[group] = source_of(group, parameters, from, fit);
  }
  const Wire<double>& before = from.wire;
  const Wire<double>& now = fit.wire;
  const std::pair<const char*, bool> others[] = {
      {"wire.memory", now.kinetics.memory != before.kinetics.memory},
      {"wire.smallest_reversal", false},
      {"wire.material.mixture", now.material.mixture != before.material.mixture},
      {"wire.material.reference", false},
      {"wire.heat.density", false}};
  for (const auto& [path, changed] : others) {
    const std::string text = structure_source(changed, inherited(from, path), fit);
    if (!text.empty()) {
      sources[path] = text;
    }
  }
  if (fit.wire.accuracy.strain > fit.strain_sd && fit.strain_sd > 0) {
    sources["wire.accuracy.strain"] = fmt::format(
        "more than the {:.2g} % that the fit to {} leaves, because the observer's "
        "reported deviation depends on it, and has to hold in other runs",
        100 * fit.strain_sd, file_names(fit));
  }
  files::WireDescription wire{name, now, {sources.begin(), sources.end()}};
  check_valid(wire);
  return wire;
}

}  // namespace smaservo::identify
