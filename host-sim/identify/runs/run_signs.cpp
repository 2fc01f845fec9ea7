#include <cmath>
#include <cstddef>
#include <fmt/format.h>
#include <limits>

#include "host-sim/identify/runs/run_checks.hpp"
#include "host-sim/identify/runs/run_statistics.hpp"

namespace smaservo::identify {
namespace {

/// The means of `values` in the rows where `where` is 1 and where it is -1; NaN if there are none.
struct Halves {
  double positive, negative;
};
Halves means(const Values& values, const Values& where) {
  double sums[2] = {}, counts[2] = {};
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!std::isnan(values[i]) && where[i] != 0) {
      const std::size_t side = where[i] > 0 ? 0 : 1;
      sums[side] += values[i];
      ++counts[side];
    }
  }
  return {sums[0] / counts[0], sums[1] / counts[1]};
}

/// 1 where the values rise over the surrounding rows, -1 where they fall, 0 where they hardly
/// change.
Values directions(const Values& values) {
  const std::size_t reach = std::max<std::size_t>(1, values.size() / 50);
  const double min = 1e-3 * span_of(values);
  Values all;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double change =
        values[std::min(i + reach, values.size() - 1)] - values[i - std::min(i, reach)];
    all.push_back(change > min ? 1 : change < -min ? -1 : 0);
  }
  return all;
}

double correlation(const Values& a, const Values& b) {
  double n = 0, sum_a = 0, sum_b = 0, aa = 0, bb = 0, ab = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (!std::isnan(a[i] - b[i])) {
      ++n;
      sum_a += a[i];
      sum_b += b[i];
      aa += a[i] * a[i];
      bb += b[i] * b[i];
      ab += a[i] * b[i];
    }
  }
  const double spread = (aa - sum_a * sum_a / n) * (bb - sum_b * sum_b / n);
  return spread > 0 ? (ab - sum_a * sum_b / n) / std::sqrt(spread) : 0;
}

/// A measure of the heating with the delay of the wire's temperature: the temperature itself, the
/// power, or the power after a first-order delay.
Values heating(const Run& run, const Geometry<double>& geometry) {
  if (run.kind == RunKind::bath) {
    return run.temperature_K;
  }
  constexpr double still_air_W_m2K = 100;
  const double delay_s =
      density_kg_m3 * specific_heat_J_kgK * geometry.diameter_m / (4 * still_air_W_m2K);
  Values all;
  double now = std::numeric_limits<double>::quiet_NaN();
  for (std::size_t i = 0; i < run.current_A.size(); ++i) {
    const double power_W = run.current_A[i] * run.voltage_V[i];
    const double step =
        run.kind == RunKind::joule && i > 0 ? (run.time_s[i] - run.time_s[i - 1]) / delay_s : 1e9;
    now = std::isnan(now) ? power_W : now + (power_W - now) * -std::expm1(-step);
    all.push_back(now);
  }
  return all;
}

/// A heat flow is positive into the sample: it is greater while the sample is heated than while it
/// is cooled; if the sample is only heated, the peak points up.
void check_heat_flow(const Run& run) {
  const Values& flow = run.power_W_kg;
  const Halves mean = means(flow, directions(run.temperature_K));
  bool wrong = mean.positive < mean.negative;
  if (std::isnan(mean.positive) || std::isnan(mean.negative)) {
    const Range range = range_of(flow);
    const bool points_up = range.high - range.middle > range.middle - range.low;
    wrong = std::isnan(mean.negative) ? !points_up : points_up;
  }
  if (wrong) {
    fail(run, fmt::format("the heat flow runs against the temperature (mean {:.3g} W/g while it "
                          "rises, {:.3g} W/g while it falls); it must be positive into the sample. "
                          "If exothermic is up: --column power_W_per_g=COLUMN*-1",
                          1e-3 * mean.positive, 1e-3 * mean.negative));
  }
}

}  // namespace

void check_signs(const Run& run, const Geometry<double>& geometry) {
  if (run.kind == RunKind::calorimetry) {
    check_heat_flow(run);
    return;
  }
  if (const double middle_Pa = range_of(run.stress_Pa).middle; middle_Pa < 0) {
    fail(run, fmt::format("the wire is pushed by {:.4g} MPa; a pull is positive, so if the load "
                          "cell is the wrong way round: --column load_N=COLUMN*-1",
                          -1e-6 * middle_Pa));
  }
  if (const double ohm = range_of(run.resistance_ohm).middle; ohm < 0) {
    fail(run, fmt::format("voltage and current have opposite signs (a resistance of {:.4g} ohm); "
                          "if the shunt is the wrong way round: --column current_A=COLUMN*-1",
                          ohm));
  }
  constexpr double surely = 0.3;
  if (!run.strain.empty() && correlation(run.strain, heating(run, geometry)) > surely) {
    fail(run,
         "the wire gets longer where it is heated, and shape-memory wire gets shorter; "
         "strain_ref is positive where the wire is long, displacement_mm where it is short. "
         "If it is the other way round: --column displacement_mm=COLUMN*-1");
  }
}

}  // namespace smaservo::identify
