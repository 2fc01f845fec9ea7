#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <numeric>
#include <span>

#include "host-sim/checks/findings.hpp"
#include "host-sim/checks/statistics.hpp"

namespace smaservo::checks {
namespace {

constexpr std::size_t min_rows = 20;

/// The longest stretch of rows at an extreme value, and the number of rows in stretches of at least
/// five.
struct Stretch {
  double value = 0;
  std::size_t first = 0, count = 0, all = 0;
};
Stretch held(const Values& values, double extreme) {
  Stretch longest{extreme};
  for (std::size_t i = 0; i < values.size();) {
    std::size_t stop = i;
    while (stop < values.size() && values[stop] == extreme) {
      ++stop;
    }
    const std::size_t count = stop - i;
    longest.all += count >= 5 ? count : 0;
    if (count > longest.count) {
      longest.first = i;
      longest.count = count;
    }
    i = stop + 1;
  }
  return longest;
}

bool is_long(const Stretch& stretch, std::size_t rows) {
  return stretch.count >= 5 && 10 * stretch.all > rows;
}

/// The values of another column in the rows of a stretch, without its first and last rows.
std::span<const double> beside(const Values& values, const Stretch& stretch) {
  const std::size_t edge = std::max<std::size_t>(1, stretch.count / 10);
  return std::span(values).subspan(stretch.first + edge, stretch.count - 2 * edge);
}

/// The span of the means of its three thirds, so that noise does not count as a change.
double change(std::span<const double> values) {
  Values means;
  for (std::size_t third = 0; third < 3; ++third) {
    const std::size_t from = third * values.size() / 3, to = (third + 1) * values.size() / 3;
    const Values some = known({values.begin() + static_cast<std::ptrdiff_t>(from),
                               values.begin() + static_cast<std::ptrdiff_t>(to)});
    if (!some.empty()) {
      means.push_back(std::accumulate(some.begin(), some.end(), 0.0) /
                      static_cast<double>(some.size()));
    }
  }
  return span_of(means);
}

/// Whether the column ends abruptly at the stretch. A quantity that comes to rest slows down first,
/// and accelerates when it leaves: the rows next to the stretch differ by no more than one step of
/// the converter, or by amounts that differ much from row to row. A clipped column arrives and
/// leaves with a steady slope.
bool breaks_off(const Values& values, const Stretch& stretch) {
  const double min = 1.5 * step_of(values);
  const auto steady = [&](double first, double second, double third) {
    return std::abs(second - first) > min &&
           std::abs(third - second) < 1.25 * std::abs(second - first);
  };
  const std::size_t at = stretch.first;
  const std::size_t after = stretch.first + stretch.count;
  const bool comes = at >= 3;
  const bool goes = after + 3 <= values.size();
  return (comes || goes) && (!comes || steady(values[at - 1], values[at - 2], values[at - 3])) &&
         (!goes || steady(values[after], values[after + 1], values[after + 2]));
}

/// Whether the noise is several fine steps in all rows outside the stretch.
bool is_noisy_elsewhere(const Values& values, const Stretch& stretch) {
  std::size_t equal = 0, pairs = 0;
  for (std::size_t i = 1; i < values.size(); ++i) {
    if (values[i] != stretch.value) {
      ++pairs;
      equal += values[i] == values[i - 1] ? 1U : 0U;
    }
  }
  return stretch.count >= min_rows && 10 * equal < pairs &&
         span_of(values) > 1000 * step_of(values);
}

}  // namespace

/// A source may hold current or voltage exactly, which is no clipping. The resistance of a wire
/// stays within 40 %, so the other quantity then changes by no more than that.
void check_converters(const Record& record, Findings& found) {
  const auto check = [&](const Values& held_values, const Values& others, bool is_voltage) {
    if (held_values.empty() || others.empty()) {
      return;
    }
    const Stretch stretch = held(held_values, *std::ranges::max_element(held_values));
    if (!is_long(stretch, held_values.size()) || !(stretch.value > 0)) {
      return;
    }
    const auto [min, max] = std::ranges::minmax(beside(others, stretch));
    if (max > 1.4 * std::max(min, 0.0)) {
      found.push_back(
          {"clipped", true,
           fmt::format(
               "{} stands still at {:.6g} {} for {} rows ({} on, {}) while {} changes by "
               "more than 40 %, which no wire's resistance allows; the converter is "
               "clipped: record again with a wider range",
               is_voltage ? "voltage" : "current", stretch.value, is_voltage ? "V" : "A",
               stretch.count, record.row(stretch.first),
               record.column(is_voltage ? hal::Column::voltage : hal::Column::current, "no column"),
               is_voltage ? "the current" : "the voltage")});
    }
  };
  check(record.voltage_V, record.current_A, true);
  check(record.current_A, record.voltage_V, false);
}

/// A column of strain, temperature or resistance is clipped if (1) more than a tenth of its rows
/// hold its least or greatest value, in stretches of at least five; (2) another quantity changes by
/// more than 5 % of its span during the longest stretch; and (3) the column arrives at this stretch
/// and leaves it with a steady slope, or is noisy in all other rows. A wire at rest, a column of
/// coarse steps and a thermostat's hold fulfil some of these conditions, not all.
void check_sensors(const Record& record, Findings& found) {
  struct Named {
    const char* name;
    const char* unit;
    hal::Column column;
    const Values& values;
  };
  const bool by_temperature = record.kind == RunKind::bath || record.kind == RunKind::calorimetry;
  const Values nothing;
  const auto strain = record.places[static_cast<std::size_t>(hal::Column::strain_ref)].column > 0
                          ? hal::Column::strain_ref
                          : hal::Column::displacement;
  const Named columns[] = {{"strain", "", strain, record.strain},
                           {"temperature", " K", hal::Column::temperature,
                            by_temperature ? record.temperature_K : nothing},
                           {"resistance", " ohm", hal::Column::resistance, record.resistance_ohm},
                           {"current", " A", hal::Column::current, record.current_A},
                           {"voltage", " V", hal::Column::voltage, record.voltage_V}};
  constexpr std::size_t judged = 3;
  for (std::size_t c = 0; c < judged; ++c) {
    const Values& values = columns[c].values;
    const double span = span_of(values);
    if (!(span > 0)) {
      continue;
    }
    const Values some = known(values);
    const auto [min, max] = std::ranges::minmax(some);
    for (const double extreme : {min, max}) {
      const Stretch stretch = held(values, extreme);
      if (!is_long(stretch, values.size())) {
        continue;
      }
      const bool others_change = std::ranges::any_of(columns, [&](const Named& other) {
        return &other.values != &values && !other.values.empty() &&
               change(beside(other.values, stretch)) > 0.05 * span_of(other.values);
      });
      if (others_change && (breaks_off(values, stretch) || is_noisy_elsewhere(values, stretch))) {
        found.push_back(
            {"clipped", true,
             fmt::format("{} stands still at {:.6g}{}, its {} value, for {} rows ({} on, {}) while "
                         "other columns change; the converter is clipped or the sensor at a stop: "
                         "record again with a wider range",
                         columns[c].name, extreme, columns[c].unit,
                         extreme == max ? "greatest" : "least", stretch.count,
                         record.row(stretch.first),
                         record.column(columns[c].column, "no column"))});
      }
    }
  }
}

}  // namespace smaservo::checks
