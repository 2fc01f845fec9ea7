#include "host-sim/checks/record.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <utility>

namespace smaservo::checks {
namespace {

constexpr double min_current_share = 0.03;

std::size_t index_of(hal::Column column) {
  return static_cast<std::size_t>(column);
}

/// V/I in rows with enough current to measure it, otherwise NaN.
std::vector<double> measured_resistance(const Record& record) {
  std::vector<double> all;
  if (record.current_A.empty() || record.voltage_V.empty()) {
    return all;
  }
  double largest_A = 0;
  for (const double current_A : record.current_A) {
    largest_A = std::max(largest_A, std::abs(current_A));
  }
  const double min_A = min_current_share * largest_A;
  for (std::size_t i = 0; i < record.current_A.size(); ++i) {
    const double current_A = record.current_A[i];
    all.push_back(current_A != 0 && std::abs(current_A) >= min_A
                      ? record.voltage_V[i] / current_A
                      : std::numeric_limits<double>::quiet_NaN());
  }
  return all;
}

std::vector<double> elongation(const std::vector<double>& displacement_m, double length_m) {
  std::vector<double> strain;
  if (displacement_m.empty()) {
    return strain;
  }
  const double longest_m = *std::ranges::min_element(displacement_m);
  for (const double at_m : displacement_m) {
    strain.push_back((longest_m - at_m) / length_m);
  }
  return strain;
}

}  // namespace

std::string_view name_of(RunKind kind) {
  switch (kind) {
    case RunKind::bath:
      return "bath";
    case RunKind::joule:
      return "joule";
    case RunKind::settled:
      return "settled";
    case RunKind::calorimetry:
      return "calorimetry";
    case RunKind::imposed:
      return "imposed strain";
  }
  return "";
}

std::string Record::row(std::size_t index) const {
  return index < lines.size() ? fmt::format("{} {}", line_word, lines[index])
                              : fmt::format("row {}", index + 1);
}

std::string Record::column(hal::Column column, std::string_view otherwise) const {
  const Place& place = places[index_of(column)];
  return place.column == 0 ? std::string(otherwise)
                           : fmt::format("column {} '{}'", place.column, place.name);
}

Recorder::Recorder(const hal::TraceReader& trace, std::size_t most) : most_(most) {
  record_.line_word = trace.word();
  for (std::size_t k = 0; k < hal::column_count; ++k) {
    const auto column = static_cast<hal::Column>(k);
    const bool period = column == hal::Column::time && trace.timed() && !trace.has(column);
    if (!trace.has(column) && !period) {
      continue;
    }
    kept_.push_back(column);
    if (trace.has(column)) {
      const std::size_t position = trace.position(column);
      const std::string own = trace.own_name(position);
      const std::size_t unit = own.find('_');
      record_.places[k] = {position + 1, trace.names()[position],
                           unit == std::string::npos ? "" : own.substr(unit + 1)};
    }
  }
}

Recorder::Recorder(std::vector<hal::Column> columns, std::string line_word, std::size_t most)
    : kept_(std::move(columns)), most_(most) {
  record_.line_word = std::move(line_word);
}

void Recorder::add(const hal::TraceRow& row) {
  if (rows() >= most_ && rows() % block == 0) {
    thin();
  }
  if (seen_++ / block % stride_ != 0) {
    return;
  }
  record_.lines.push_back(row.line);
  for (const hal::Column column : kept_) {
    values_[index_of(column)].push_back(row[column]);
  }
}

/// Drops every second block; most_ is many blocks.
void Recorder::thin() {
  const auto halve = [](auto& values) {
    std::size_t to = 0;
    for (std::size_t from = 0; from < values.size(); ++from) {
      if (from / block % 2 == 0) {
        values[to++] = values[from];
      }
    }
    values.resize(to);
  };
  halve(record_.lines);
  for (const hal::Column column : kept_) {
    halve(values_[index_of(column)]);
  }
  stride_ *= 2;
}

Record Recorder::finish(const std::string& name, const Geometry<double>& geometry) {
  Record record = std::move(record_);
  const auto take = [&](hal::Column column) { return std::move(values_[index_of(column)]); };
  record.name = name;
  record.time_s = take(hal::Column::time);
  record.current_A = take(hal::Column::current);
  record.voltage_V = take(hal::Column::voltage);
  record.stress_Pa = take(hal::Column::stress);
  record.strain = take(hal::Column::strain_ref);
  record.resistance_ohm = take(hal::Column::resistance);
  record.temperature_K = take(hal::Column::temperature);
  record.ambient_K = take(hal::Column::ambient);
  record.power_W_kg = take(hal::Column::power);
  record.heating_W = take(hal::Column::heating);
  if (record.stress_Pa.empty()) {
    for (const double newton : of(hal::Column::load)) {
      record.stress_Pa.push_back(newton / geometry.area_m2());
    }
  }
  if (record.strain.empty()) {
    record.strain = elongation(of(hal::Column::displacement), geometry.length_m);
  }
  if (record.resistance_ohm.empty()) {
    record.resistance_ohm = measured_resistance(record);
  }
  return record;
}

}  // namespace smaservo::checks
