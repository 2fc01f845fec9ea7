#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "host-sim/papers/figures/000/paper_000.hpp"
#include "model/units.hpp"

namespace smaservo::figures::paper_000 {
namespace {

using Kinetics = ThreePhase<double>;

/// The model of the paper: inner loops by scaling, without memory.
Kinetics::Params paper_kinetics() {
  Kinetics::Params p = paper_wire().kinetics;
  p.memory = Memory::plain;
  return p;
}

/// Mean over 3 K, like the lag of a calorimeter, because the simulated wire has grains.
std::vector<double> smoothed(const CalorimetryRun& run) {
  std::vector<double> means;
  const std::size_t rows = run.temperature_K.size();
  for (std::size_t i = 0; i < rows; ++i) {
    const std::size_t half = i < run.hottest() ? 0 : run.hottest();
    double sum = 0;
    int count = 0;
    for (std::size_t k = half; k < std::min(half + run.hottest(), rows); ++k) {
      if (std::abs(run.temperature_K[k] - run.temperature_K[i]) <= 1.5) {
        sum += run.transforming_W_kg[k];
        ++count;
      }
    }
    means.push_back(sum / count);
  }
  return means;
}

/// The interpolated place at which a rising or falling column passes a value.
double where(const std::vector<double>& column, const std::vector<double>& at, std::size_t from,
             std::size_t to, double value) {
  for (std::size_t i = from; i < to; ++i) {
    const double before = column[i] - value;
    const double after = column[i + 1] - value;
    if (before != after && before * after <= 0) {
      return at[i] + (at[i + 1] - at[i]) * before / (before - after);
    }
  }
  return at[to];
}

double min(const std::vector<double>& values, std::size_t from, std::size_t to) {
  return *std::min_element(values.begin() + static_cast<std::ptrdiff_t>(from),
                           values.begin() + static_cast<std::ptrdiff_t>(to));
}
double max(const std::vector<double>& values, std::size_t from, std::size_t to) {
  return *std::max_element(values.begin() + static_cast<std::ptrdiff_t>(from),
                           values.begin() + static_cast<std::ptrdiff_t>(to));
}
double span(const std::vector<double>& values) {
  return max(values, 0, values.size()) - min(values, 0, values.size());
}

double deviation_from_line(const std::vector<double>& x, const std::vector<double>& y) {
  const auto n = static_cast<double>(x.size());
  const double x_mean = std::accumulate(x.begin(), x.end(), 0.0) / n;
  const double y_mean = std::accumulate(y.begin(), y.end(), 0.0) / n;
  double xx = 0;
  double xy = 0;
  double yy = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    xx += (x[i] - x_mean) * (x[i] - x_mean);
    xy += (x[i] - x_mean) * (y[i] - y_mean);
    yy += (y[i] - y_mean) * (y[i] - y_mean);
  }
  return std::sqrt(std::max(0.0, yy - xy * xy / xx) / n);
}

}  // namespace

Peaks peaks(const CalorimetryRun& run) {
  const std::vector<double> power = smoothed(run);
  const auto end = static_cast<std::ptrdiff_t>(run.hottest());
  const auto heating = std::max_element(power.begin(), power.begin() + end) - power.begin();
  // The peaks of A2R and R2M are on either side of 50 °C.
  Peaks found{run.temperature_K[static_cast<std::size_t>(heating)], 0, 0};
  double a2r = 0;
  double r2m = 0;
  for (std::size_t i = run.hottest(); i < power.size(); ++i) {
    const double T = run.temperature_K[i];
    const bool above = T > 50 + zero_degC_K;
    double& max = above ? a2r : r2m;
    if (-power[i] > max) {
      max = -power[i];
      (above ? found.a2r_K : found.r2m_K) = T;
    }
  }
  return found;
}

std::vector<double> resistances_ohm(const BathRun& run) {
  std::vector<double> all;
  all.reserve(run.rows());
  for (std::size_t i = 0; i < run.rows(); ++i) {
    all.push_back(resistance_ohm(run.resistivity_ohm_m[i], paper_wire().length_per_area_1_m(),
                                 run.strain[i]));
  }
  return all;
}

SelfSensing self_sensing(const BathRun& run) {
  const std::vector<double> ohm = resistances_ohm(run);
  const std::size_t hot = run.hottest();
  const std::size_t end = run.rows() - 1;
  const double low = std::max(min(run.strain, 0, hot + 1), min(run.strain, hot, end + 1));
  const double high = std::min(max(run.strain, 0, hot + 1), max(run.strain, hot, end + 1));
  double gap_ohm = 0;
  // The ends are left out, because strain hardly changes with resistance there.
  for (double share = 0.05; share < 0.955; share += 0.01) {
    const double strain = low + share * (high - low);
    const double here =
        where(run.strain, ohm, hot, end, strain) - where(run.strain, ohm, 0, hot, strain);
    gap_ohm = std::abs(here) > std::abs(gap_ohm) ? here : gap_ohm;
  }
  return {gap_ohm / span(ohm), deviation_from_line(ohm, run.strain) / span(run.strain)};
}

std::vector<identify::ClassicFit> transformation_functions(const BathRun& run) {
  // The row with the wire's earlier temperature is left out, because the fits use no history.
  identify::Run cycle{};
  cycle.kind = identify::RunKind::bath;
  cycle.temperature_K = run.temperature_K;
  cycle.strain = run.strain;
  cycle.stress_Pa.assign(run.rows(), 1e6 * run.stress_MPa);
  std::vector<identify::ClassicFit> all = identify::fit_classics(cycle);
  for (identify::ClassicFit& fit : identify::fit_adaptable(cycle)) {
    all.push_back(std::move(fit));
  }
  return all;
}

IhypParts ihyp_parts(const IhypShape<double>& shape, double converted) {
  // tau = x + Γ [(1 - z_T)³/(1 - x) - (1 - z_T)² - z_T³/x + z_T² - (x - z_T)] (000, reconstructed
  // in model/README.md)
  const double a = shape.turning;
  const double b = 1 - a;
  const double x = converted;
  return {-shape.curvature * a * a * a / x, shape.curvature * b * b * b / (1 - x),
          x + shape.curvature * (a * a - b * b - (x - a))};
}

InnerLoop inner_loop() {
  Kinetics::Params p = paper_kinetics();
  // A2R is moved far below all temperatures, which gives a wire of two phases.
  Surface<double> a2r = second_surface(p.a2m_a2r);
  a2r.start_K[0] = 60;
  a2r.finish_K[0] = 55;
  p.a2m_a2r = pair_surfaces(first_surface(p.a2m_a2r), a2r);
  const Isobar<double> m2a = isobar(p.m2a, 0.0);
  const Isobar<double> a2m = isobar(first_surface(p.a2m_a2r), 0.0);
  const double cold_K = 10 + zero_degC_K;
  const double hot_K = 110 + zero_degC_K;
  const double reversal_K = 75 + zero_degC_K;
  const double step_K = 0.5;
  InnerLoop loop;
  for (double T = cold_K; T <= hot_K; T += step_K) {
    loop.temperature_K.push_back(T);
    loop.heating.push_back(m2a.remaining(T));
    loop.cooling.push_back(1 - a2m.remaining(T));
  }
  Kinetics::State back = Kinetics::with_phases(p, {reversal_K, 0}, {m2a.remaining(reversal_K), 0});
  for (double T = reversal_K; T >= cold_K; T -= step_K) {
    Kinetics::advance(p, back, {T, 0});
    loop.back_K.push_back(T);
    loop.back.push_back(back.martensite);
  }
  return loop;
}

std::vector<HeatingBar> heating_bars() {
  const Kinetics::Params p = paper_kinetics();
  const double stress_Pa = 1e6 * heating_bars_MPa;
  // R-phase and martensite as they are when the first bar begins.
  Kinetics::State state = Kinetics::rest(p, {50 + zero_degC_K, stress_Pa});
  double T = 66 + zero_degC_K;
  Kinetics::advance(p, state, {T, stress_Pa});
  std::vector<HeatingBar> bars;
  while (T < 99 + zero_degC_K) {
    T += bar_step_K;
    const Phases<double> before = Kinetics::phases(state);
    Kinetics::advance(p, state, {T, stress_Pa});
    const Phases<double> after = Kinetics::phases(state);
    bars.push_back({T, after.martensite, before.martensite - after.martensite, before.austenite(),
                    before.r_phase - after.r_phase, after.r_phase});
  }
  return bars;
}

std::vector<CoolingBar> cooling_bars() {
  const Kinetics::Params p = paper_kinetics();
  const double stress_Pa = 1e6 * cooling_bars_MPa;
  const Isobar<double> a2m = isobar(first_surface(p.a2m_a2r), stress_Pa);
  const Isobar<double> a2r = isobar(second_surface(p.a2m_a2r), stress_Pa);
  double T = 75 + zero_degC_K;
  Kinetics::State state = Kinetics::rest(p, {T, stress_Pa});
  std::vector<CoolingBar> bars;
  while (T > 39 + zero_degC_K) {
    const double before_K = T;
    T -= bar_step_K;
    const Phases<double> before = Kinetics::phases(state);
    // Each process is computed as if it had all austenite for itself (000, 'Cooling process').
    const double to_m = 1 - a2m.remaining(T) / a2m.remaining(before_K);
    const double to_r = 1 - a2r.remaining(T) / a2r.remaining(before_K);
    const double a = before.austenite();
    bars.push_back({T, before.martensite, a * to_m * (1 - to_r), a * to_m * to_r,
                    a * (1 - to_m) * (1 - to_r), a * to_r * (1 - to_m), before.r_phase * (1 - to_m),
                    before.r_phase * to_m});
    Kinetics::advance(p, state, {T, stress_Pa});
  }
  return bars;
}

}  // namespace smaservo::figures::paper_000
