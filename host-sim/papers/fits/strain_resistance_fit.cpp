#include "host-sim/papers/fits/strain_resistance_fit.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <fmt/format.h>
#include <limits>

#include "host-sim/identify/runs/steady_load.hpp"
#include "host-sim/papers/fits/full_branches.hpp"
#include "model/files/error.hpp"

namespace smaservo::fits {
namespace {

using Observer = papers::StrainResistance<double>;

double stroke(const identify::Run& run) {
  const auto [shortest, longest] = std::ranges::minmax(run.strain);
  return longest - shortest;
}

/// R_0: the median resistance of the rows within a twentieth of the stroke from the longest wire.
double martensite_ohm(const std::vector<identify::Run>& runs) {
  std::vector<double> long_ohm;
  for (const identify::Run& run : runs) {
    const double min = *std::ranges::max_element(run.strain) - 0.05 * stroke(run);
    for (std::size_t i = 0; i < run.strain.size(); ++i) {
      if (run.strain[i] > min && std::isfinite(run.resistance_ohm[i])) {
        long_ohm.push_back(run.resistance_ohm[i]);
      }
    }
  }
  if (long_ohm.empty()) {
    throw files::UserError(
        "no run has a resistance where the wire is long (within a twentieth of its stroke); let a "
        "small current flow while it is cold");
  }
  return identify::quantile(long_ohm, 0.5);
}

double row_s(const identify::Run& run, std::size_t i) {
  constexpr double settled_s = 1e3;
  return run.time_s.empty() || i == 0 ? settled_s : run.time_s[i] - run.time_s[i - 1];
}

/// Four standard deviations of the noise of the smoothed resistance, from the second differences in
/// short windows. The noisiest windows count, since the noise grows as the current falls.
double smallest_reversal(const std::vector<identify::Run>& runs, double ohm) {
  constexpr std::size_t window = 50;
  constexpr double min = 1e-4;
  std::vector<double> noise;
  for (const identify::Run& run : runs) {
    const std::vector<double>& R = run.resistance_ohm;
    for (std::size_t begin = 1; begin + window + 1 < R.size(); begin += window) {
      std::vector<double> bends;
      for (std::size_t i = begin; i < begin + window; ++i) {
        const double bend = R[i - 1] - 2 * R[i] + R[i + 1];
        if (std::isfinite(bend)) {
          bends.push_back(std::abs(bend));
        }
      }
      if (bends.size() == window) {
        // The variance of a second difference is six times that of the noise.
        const double sd = identify::quantile(bends, 0.5) / (0.6745 * std::sqrt(6.0));
        const double dt_s = row_s(run, begin);
        const double weight = dt_s / (dt_s + Observer::smoothing_s);
        noise.push_back(sd / ohm * std::sqrt(weight / (2 - weight)));
      }
    }
  }
  return noise.empty() ? min : std::max(min, 4 * identify::quantile(noise, 0.9));
}

/// The slope is the median over all pairs of points, the offset the median of the remainders.
papers::ResistanceLine<double> theil_sen(
    const std::vector<papers::ResistancePoint<double>>& points) {
  std::vector<double> slopes;
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      const double way = points[i].resistance - points[k].resistance;
      if (std::abs(way) > 1e-6) {
        slopes.push_back((points[i].strain - points[k].strain) / way);
      }
    }
  }
  const double slope = slopes.empty() ? 0 : identify::quantile(slopes, 0.5);
  std::vector<double> offsets;
  offsets.reserve(points.size());
  for (const auto& point : points) {
    offsets.push_back(point.strain - slope * point.resistance);
  }
  return {slope, identify::quantile(offsets, 0.5)};
}

/// The points of all branches at one load.
struct Collected {
  double stress_Pa;
  std::vector<papers::ResistancePoint<double>> heating, cooling;
};

std::vector<Collected> collect(const std::vector<identify::Run>& runs, double ohm) {
  constexpr double min_stroke = 0.01;
  double longest = 0;
  for (const identify::Run& run : runs) {
    longest = std::max(longest, stroke(run));
  }
  std::vector<Collected> levels;
  for (const identify::Run& run : runs) {
    if (!identify::has_constant_stress(run) || stroke(run) < std::max(min_stroke, 0.5 * longest)) {
      continue;
    }
    const FullBranches branches = full_branches(run, ohm);
    if (branches.heating.empty() || branches.cooling.empty()) {
      continue;
    }
    const double stress_Pa = identify::quantile(run.stress_Pa, 0.5);
    const auto same = std::ranges::find_if(levels, [&](const Collected& level) {
      return std::abs(level.stress_Pa - stress_Pa) < std::max(0.05 * stress_Pa, 2e6);
    });
    Collected& level =
        same != levels.end() ? *same : levels.emplace_back(Collected{stress_Pa, {}, {}});
    level.heating.insert(level.heating.end(), branches.heating.begin(), branches.heating.end());
    level.cooling.insert(level.cooling.end(), branches.cooling.begin(), branches.cooling.end());
  }
  std::ranges::sort(levels, {}, &Collected::stress_Pa);
  return levels;
}

papers::ResistanceLine<double> rising_line(const Collected& level, bool heats) {
  const papers::ResistanceLine<double> line = theil_sen(heats ? level.heating : level.cooling);
  if (!(line.slope > 0)) {
    throw files::UserError(fmt::format(
        "the runs at {:.0f} MPa: strain does not rise with resistance on {} (slope {:.3f}), so no "
        "line gives strain from resistance; leave this load out or take a heavier one",
        level.stress_Pa * 1e-6, heats ? "heating" : "cooling", line.slope));
  }
  return line;
}

std::vector<LoadLevel> fit_levels(const std::vector<identify::Run>& runs, double ohm) {
  std::vector<LoadLevel> levels;
  for (const Collected& level : collect(runs, ohm)) {
    levels.push_back({level.stress_Pa, rising_line(level, true), rising_line(level, false)});
  }
  if (levels.empty()) {
    throw files::UserError(fmt::format(
        "{} runs: none of constant load has a full heating and a full cooling, from 90 % of its "
        "stroke (which must be 1 % of the length, and half of the other runs') to 10 % without "
        "turning; measure at least one whole loop at each load",
        runs.size()));
  }
  return levels;
}

/// The coefficients of the least-squares polynomial by rising power. There must be more points than
/// the order, and x must be of the order of one.
std::vector<double> fit_polynomial(const std::vector<double>& x, const std::vector<double>& y,
                                   int order) {
  const auto rows = static_cast<Eigen::Index>(x.size());
  Eigen::MatrixXd powers(rows, order + 1);
  Eigen::VectorXd values(rows);
  for (Eigen::Index i = 0; i < rows; ++i) {
    values(i) = y[static_cast<std::size_t>(i)];
    double power = 1;
    for (int k = 0; k <= order; ++k) {
      powers(i, k) = power;
      power *= x[static_cast<std::size_t>(i)];
    }
  }
  const Eigen::VectorXd solved = powers.colPivHouseholderQr().solve(values);
  return {solved.data(), solved.data() + solved.size()};
}

papers::StressPolynomial<double> polynomial(const std::vector<LoadLevel>& levels, int order,
                                            double (*number)(const LoadLevel&)) {
  std::vector<double> x, y;
  for (const LoadLevel& level : levels) {
    x.push_back(level.stress_Pa / levels.back().stress_Pa);
    y.push_back(number(level));
  }
  papers::StressPolynomial<double> fitted{};
  std::ranges::copy(fit_polynomial(x, y, order), fitted.coefficient);
  return fitted;
}

void fit_polynomials(StrainResistanceFit& fit) {
  const auto of = [&](double (*number)(const LoadLevel&)) {
    return polynomial(fit.levels, fit.order, number);
  };
  fit.params.heating = {of([](const LoadLevel& l) { return l.heating.slope; }),
                        of([](const LoadLevel& l) { return l.heating.offset; })};
  fit.params.cooling = {of([](const LoadLevel& l) { return l.cooling.slope; }),
                        of([](const LoadLevel& l) { return l.cooling.offset; })};
}

/// The least slope of both lines between the lightest and the heaviest load.
double min_slope(const Observer::Params& p) {
  constexpr int steps = 200;
  double min = std::numeric_limits<double>::infinity();
  for (int i = 0; i <= steps; ++i) {
    const double stress_Pa = p.min_stress_Pa + (p.max_stress_Pa - p.min_stress_Pa) * i / steps;
    min = std::min({min, Observer::line(p.heating, p, stress_Pa).slope,
                    Observer::line(p.cooling, p, stress_Pa).slope});
  }
  return min;
}

double mean_square(const Observer::Params& params, const std::vector<identify::Run>& runs) {
  double squares = 0;
  std::size_t count = 0;
  for (const identify::Run& run : runs) {
    const std::vector<double> strain = estimate_strain(params, run);
    for (std::size_t i = 0; i < strain.size(); ++i) {
      squares += (strain[i] - run.strain[i]) * (strain[i] - run.strain[i]);
    }
    count += strain.size();
  }
  return squares / static_cast<double>(count);
}

/// Least squares over a_0 (as a share of the least slope) and the logarithm of τ, on a grid that
/// contracts around its best node: the valley is curved and shallow, and an evaluation is cheap.
void fit_transitions(Observer::Params& p, const std::vector<identify::Run>& runs) {
  const double slope = min_slope(p);
  std::array<double, 2> best{0.4, std::log(60.0)};
  std::array<double, 2> width{0.4, 3.0};
  double min = std::numeric_limits<double>::infinity();
  for (int round = 0; round < 6; ++round) {
    const std::array<double, 2> middle = best;
    for (int i = -3; i <= 3; ++i) {
      for (int k = -3; k <= 3; ++k) {
        const double share = std::clamp(middle[0] + width[0] * i / 3, 0.0, 0.95);
        const double log_decay = middle[1] + width[1] * k / 3;
        Observer::Params tried = p;
        tried.initial_slope = share * slope;
        tried.decay = std::exp(log_decay);
        const double cost = mean_square(tried, runs);
        if (cost < min) {
          min = cost;
          best = {share, log_decay};
          p.initial_slope = tried.initial_slope;
          p.decay = tried.decay;
        }
      }
    }
    width = {0.5 * width[0], 0.5 * width[1]};
  }
  p.strain_sd = std::sqrt(min);
}

void check(const std::vector<identify::Run>& runs) {
  for (const identify::Run& run : runs) {
    const bool usable = run.kind == identify::RunKind::joule || run.kind == identify::RunKind::bath;
    if (!usable || run.strain.empty() || run.resistance_ohm.empty() || run.stress_Pa.empty()) {
      throw files::UserError(fmt::format(
          "{}: a run of kind {} with {} strains, {} resistances and {} stresses; all three are "
          "needed, of a joule or bath run",
          run.name, identify::name_of(run.kind), run.strain.size(), run.resistance_ohm.size(),
          run.stress_Pa.size()));
    }
  }
}

}  // namespace

StrainResistanceFit identify_strain_resistance(const std::vector<identify::Run>& runs) {
  check(runs);
  StrainResistanceFit fit{};
  Observer::Params& p = fit.params;
  p.martensite_ohm = runs.empty() ? 0 : martensite_ohm(runs);
  fit.levels = fit_levels(runs, p.martensite_ohm);
  p.min_stress_Pa = fit.levels.front().stress_Pa;
  p.max_stress_Pa = fit.levels.back().stress_Pa;
  fit.order =
      std::min(papers::StressPolynomial<double>::order, static_cast<int>(fit.levels.size()) - 1);
  // If a polynomial oscillates below zero between the loads, one of lower order is used.
  for (fit_polynomials(fit); !(min_slope(p) > 0); fit_polynomials(fit)) {
    --fit.order;
  }
  std::vector<identify::Run> thin;
  thin.reserve(runs.size());
  for (const identify::Run& run : runs) {
    // Transitions are slower than 0.02 s, and every trial runs through all rows.
    thin.push_back(averaged(run, 0.02));
  }
  p.smallest_reversal = smallest_reversal(runs, p.martensite_ohm);
  fit_transitions(p, thin);
  return fit;
}

std::vector<double> estimate_strain(const Observer::Params& params, const identify::Run& run) {
  std::vector<double> strain;
  Observer::State s{};
  for (std::size_t i = 0; i < run.strain.size(); ++i) {
    const double ohm = run.resistance_ohm[i];
    const Measurement<double> m{ohm, 0, 0, run.stress_Pa[i], std::isfinite(ohm), false, true};
    if (i == 0) {
      s = Observer::start(params, m, room_K);
    } else {
      Observer::advance(params, s, m, row_s(run, i));
    }
    strain.push_back(Observer::estimate(params, s).strain);
  }
  return strain;
}

}  // namespace smaservo::fits
