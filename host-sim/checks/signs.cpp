#include <cmath>
#include <cstddef>
#include <fmt/format.h>
#include <limits>

#include "host-sim/checks/findings.hpp"
#include "host-sim/checks/statistics.hpp"

namespace smaservo::checks {
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

/// What to type for a column that is counted the other way: "current_mA=2*-1".
std::string turned(const Record& record, hal::Column column, const char* name) {
  const Place& place = record.places[static_cast<std::size_t>(column)];
  const std::string known(name);
  return place.column == 0 ? fmt::format("{}=COLUMN*-1", known)
                           : fmt::format("{}_{}={}*-1", known.substr(0, known.find('_')),
                                         place.unit, place.column);
}

/// A heat flow is positive into the sample: it is greater while the sample is heated than while it
/// is cooled; if the sample is only heated, the peak points up.
void check_heat_flow(const Record& run, Findings& found) {
  const Values& flow = run.power_W_kg;
  const Halves mean = means(flow, directions(run.temperature_K));
  bool wrong = mean.positive < mean.negative;
  if (std::isnan(mean.positive) || std::isnan(mean.negative)) {
    const Range range = range_of(flow);
    const bool points_up = range.high - range.middle > range.middle - range.low;
    wrong = std::isnan(mean.negative) ? !points_up : points_up;
  }
  if (wrong) {
    const bool both = !std::isnan(mean.positive) && !std::isnan(mean.negative);
    found.push_back(
        {"direction", true,
         fmt::format("the heat flow runs against the temperature ({}); it must be positive into "
                     "the sample. If exothermic is up: --column {}",
                     both ? fmt::format("mean {:.3g} W/g while it rises, {:.3g} W/g while it falls",
                                        1e-3 * mean.positive, 1e-3 * mean.negative)
                          : "its peak points the wrong way",
                     turned(run, hal::Column::power, "power_W_per_g"))});
  }
}

}  // namespace

void check_signs(const Record& record, const RecordedWire& wire, Findings& found) {
  if (record.kind == RunKind::calorimetry) {
    check_heat_flow(record, found);
    return;
  }
  if (const double middle_Pa = range_of(record.stress_Pa).middle; middle_Pa < 0) {
    const auto load = record.places[static_cast<std::size_t>(hal::Column::load)].column > 0
                          ? hal::Column::load
                          : hal::Column::stress;
    found.push_back(
        {"direction", true,
         fmt::format("the wire is pushed by {:.4g} MPa ({}); a pull is positive, so if the load "
                     "cell is the wrong way round: --column {}",
                     -1e-6 * middle_Pa, record.column(load, "its load"),
                     turned(record, load, load == hal::Column::load ? "load_N" : "stress_MPa"))});
  }
  if (const double ohm = range_of(record.resistance_ohm).middle; ohm < 0) {
    found.push_back(
        {"direction", true,
         fmt::format("voltage and current have opposite signs (a resistance of {:.4g} ohm); "
                     "if the shunt or the sense leads are the wrong way round: --column {}",
                     ohm, turned(record, hal::Column::current, "current_A"))});
  }
  constexpr double surely = 0.3;
  // Without a voltage, as where its column is not understood, nothing says when the wire is heated.
  const Values heating = heating_K(record, wire.geometry);
  // A test frame that sets the strain may stretch the wire while it is heated; the force rises
  // then. A spring's force does so where the strain has the wrong sign.
  const bool frame = record.kind == RunKind::imposed;
  const bool may_be_frame = record.strain.size() == record.stress_Pa.size() &&
                            correlation(record.strain, record.stress_Pa) > surely;
  if (!frame && record.strain.size() == heating.size() &&
      correlation(record.strain, heating) > surely) {
    const Place& strain = record.places[static_cast<std::size_t>(hal::Column::strain_ref)];
    found.push_back(
        {"direction", true,
         fmt::format(
             "the wire gets longer where it is heated, and shape-memory wire gets shorter; "
             "strain_ref is positive where the wire is long, displacement_mm where it is short. "
             "If it is the other way round: --column {}{}",
             strain.column > 0 ? fmt::format("strain_ref={}*-1", strain.column)
                               : turned(record, hal::Column::displacement, "displacement_mm"),
             may_be_frame ? ". If a test frame stretched it: identify --imposed-strain" : "")});
  }
}

}  // namespace smaservo::checks
