#include "hal/replay/trace_columns.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <limits>
#include <utility>

#include "hal/recording/trimmed.hpp"
#include "model/files/error.hpp"
#include "model/files/similar.hpp"

namespace smaservo::hal {
namespace {

struct Known {
  std::string_view base;
  Kind kind;
  double low, high;  ///< bounds in SI; a value outside makes the row bad
};

constexpr std::array<Known, column_count> known_columns{{
    {"time", kind::time, -9e9, 9e9},
    {"current", kind::current, -1e3, 1e3},
    {"voltage", kind::voltage, -1e4, 1e4},
    {"load", kind::force, -1e3, 1e5},
    {"stress", kind::stress, -1e9, 1e10},
    {"temperature", kind::temperature, 50, 2000},
    {"ambient", kind::temperature, 150, 500},
    {"strain_ref", kind::number, -1, 1},
    {"displacement", kind::length, -10, 10},
    {"resistance", kind::resistance, 0, 1e6},
    {"power", kind::specific_power, -1e7, 1e7},
    {"power", kind::power, 0, 1e4},
    {"supply", kind::voltage, -1e4, 1e4},
    {"driver", kind::temperature, 50, 2000},
    {"emergency_stop", kind::count, 0, 1},
    {"driver_fault", kind::count, 0, 1},
    {"sequence", kind::count, 0, 4294967295.0},
    {"fresh", kind::count, 0, 1},
}};

/// Whether a reader with these options understands the column.
constexpr bool understood(Column column, const TraceOptions& options) {
  return column < Column::resistance ||
         (column < Column::supply ? options.resistance_and_power : options.device);
}

/// Whether the column's fields may be empty: a reading may have failed, but time, sequence and
/// flags are always present.
constexpr bool may_be_empty(Column column, const TraceOptions& options) {
  return options.device && column != Column::time &&
         (column <= Column::ambient || column == Column::supply || column == Column::driver);
}

constexpr double not_there = std::numeric_limits<double>::quiet_NaN();

/// Reads a number at `at` and moves `at` behind it; NaN if there is none. A plain decimal of up to
/// 15 digits needs one exact division (Clinger 1990); the others are parsed by the standard
/// library, which takes four times as long.
double parse_number(const char*& at, const char* stop) {
  constexpr std::array<double, 16> powers{1e0, 1e1, 1e2,  1e3,  1e4,  1e5,  1e6,  1e7,
                                          1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15};
  const char* p = at;
  const bool negative = p < stop && *p == '-';
  p += negative ? 1 : 0;
  std::uint64_t digits = 0;
  const auto read_digits = [&] {
    const char* from = p;
    for (; p < stop && *p >= '0' && *p <= '9'; ++p) {
      digits = 10 * digits + static_cast<std::uint64_t>(*p - '0');
    }
    return p - from;
  };
  const auto whole = read_digits();
  std::ptrdiff_t decimals = 0;
  if (p < stop && *p == '.') {
    ++p;
    decimals = read_digits();
  }
  if (whole > 0 && whole + decimals <= 15 && (p == stop || *p == ',')) {
    at = p;
    const double value = static_cast<double>(digits) / powers[static_cast<std::size_t>(decimals)];
    return negative ? -value : value;
  }
  double value = 0;
  const auto [after, error] = std::from_chars(at, stop, value);
  if (error != std::errc{} || !(after == stop || *after == ',')) {
    return not_there;
  }
  at = after;
  return value;
}

/// Whether the text after a known name looks like a unit.
bool looks_like_unit(std::string_view suffix) {
  return !suffix.empty() && suffix.find('_') == std::string_view::npos && suffix.size() <= 4;
}

std::string field(const char* at, const char* stop) {
  const std::string_view rest(at, static_cast<std::size_t>(stop - at));
  return fmt::format("'{}'", rest.substr(0, std::min<std::size_t>(rest.find(','), 40)));
}

std::optional<BadRow> bad_number(std::size_t i, const char* at, const char* stop) {
  if (at < stop && (*at == ' ' || *at == '+')) {
    return BadRow{i, fmt::format("{} begins with a space or a plus sign", field(at, stop))};
  }
  const std::string text = field(at, stop);
  return BadRow{i, text == "''" ? "the field is empty" : text + " is not a finite number"};
}

/// The names that a column of this quantity may have: "current_A, current_mA".
std::string names_of(const Known& column) {
  std::vector<std::string> all;
  for (const Unit& unit : column.kind) {
    all.push_back(unit.suffix.empty() ? std::string(column.base)
                                      : fmt::format("{}_{}", column.base, unit.suffix));
  }
  return fmt::format("{}", fmt::join(all, ", "));
}

/// The index of a quantity among the known columns.
std::size_t index_of(std::string_view base) {
  return static_cast<std::size_t>(std::ranges::find(known_columns, base, &Known::base) -
                                  known_columns.begin());
}

[[noreturn]] void fail(const std::string& reason) {
  throw files::UserError(reason);
}

}  // namespace

std::string si_name(Column column) {
  const Known& known = known_columns[static_cast<std::size_t>(column)];
  const std::string_view unit = known.kind.front().suffix;
  return unit.empty() ? std::string(known.base) : fmt::format("{}_{}", known.base, unit);
}

TraceColumns::TraceColumns(std::string_view header, const TraceOptions& options, std::string place,
                           bool foreign)
    : options_(options), place_(std::move(place)), foreign_(foreign) {
  for (std::size_t from = 0; from <= header.size();) {
    const std::size_t comma = std::min(header.find(',', from), header.size());
    names_.emplace_back(trimmed(header.substr(from, comma - from)));
    from = comma + 1;
  }
  targets_.resize(names_.size());
  for (const std::string& rename : options_.renames) {
    apply_rename(rename);
  }
  for (std::size_t i = 0; i < names_.size(); ++i) {
    if (targets_[i].value == column_count) {
      explain(i, names_[i]);
    }
  }
  recognise();
  take_resistance();
  leave_power();
  for (std::size_t i = 0; i < names_.size(); ++i) {
    if (targets_[i].value == column_count) {
      unknown_.push_back(i);
    }
  }
}

bool TraceColumns::is_own_header(std::string_view line) {
  std::array<bool, column_count> own{}, foreign{};
  while (!line.empty()) {
    const std::size_t comma = std::min(line.find(','), line.size());
    const std::string_view name = trimmed(line.substr(0, comma));
    const auto* const known = std::ranges::find_if(known_columns, [&](const Known& column) {
      return unit_of(name, column.base, column.kind).has_value();
    });
    if (known != known_columns.end()) {
      own[static_cast<std::size_t>(known - known_columns.begin())] = true;
    } else if (const auto meaning = meaning_of(name); meaning && meaning->doubt.empty()) {
      foreign[index_of(meaning->base)] = true;
    }
    line.remove_prefix(std::min(comma + 1, line.size()));
  }
  // Temperatures of other names stand in this project's own logs.
  for (const Column column : {Column::time, Column::current, Column::voltage, Column::load}) {
    const auto k = static_cast<std::size_t>(column);
    if (foreign[k] && !own[k]) {
      return false;
    }
  }
  return std::ranges::find(own, true) != own.end();
}

/// Where there is a current and no voltage, a resistance tells the voltage: U = R I.
void TraceColumns::take_resistance() {
  constexpr auto ohm = static_cast<std::size_t>(Column::resistance);
  if (options_.device || has(Column::voltage) || !has(Column::current)) {
    return;
  }
  if (!options_.resistance_and_power) {
    options_.resistance_and_power = true;
    for (std::size_t i = 0; i < names_.size() && !has_[ohm]; ++i) {
      const auto unit = unit_of(names_[i], known_columns[ohm].base, known_columns[ohm].kind);
      const auto meaning = meaning_of(names_[i]);
      if (targets_[i].value == column_count && unit) {
        targets_[i] = {ohm, *unit, 1};
        has_[ohm] = true;
      } else if (targets_[i].value == column_count && meaning && meaning->base == "resistance" &&
                 !meaning->unit.empty()) {
        take(i, *meaning);
      }
    }
    options_.resistance_and_power = false;
  }
  voltage_of_resistance_ = has_[ohm];
  has_[static_cast<std::size_t>(Column::voltage)] = has_[ohm];
  if (voltage_of_resistance_) {
    const std::size_t i = position(Column::resistance);
    recognised_ += fmt::format("{}voltage = current times the resistance of column {} '{}'",
                               recognised_.empty() ? "" : "; ", i + 1, names_[i]);
  }
}

/// Leaves an electrical power as text that follows from other columns, or is a calorimeter's beside
/// the one per mass.
void TraceColumns::leave_power() {
  constexpr auto heating = static_cast<std::size_t>(Column::heating);
  if (has_[heating] && (has(Column::current) || has(Column::voltage) || has(Column::power))) {
    targets_[position(Column::heating)] = {};
    has_[heating] = false;
  }
}

/// Takes columns by their meaning where the file has none by name. Where two may be the same
/// quantity, or a unit is missing, none is taken.
void TraceColumns::recognise() {
  struct Found {
    std::size_t column;
    Meaning meaning;
  };
  std::array<std::vector<Found>, column_count> found;
  for (std::size_t i = 0; i < names_.size(); ++i) {
    const auto meaning = meaning_of(names_[i]);
    if (!meaning || targets_[i].value != column_count) {
      continue;
    }
    const std::size_t k = index_of(meaning->base);
    if (understood(static_cast<Column>(k), options_) && !has_[k]) {
      found[k].push_back({i, *meaning});
    }
  }
  for (const std::vector<Found>& all : found) {
    const bool certain = all.size() == 1 && all[0].meaning.doubt.empty();
    if (certain && !all[0].meaning.unit.empty()) {
      take(all[0].column, all[0].meaning);
      continue;
    }
    for (const auto& [i, meaning] : all) {
      hint(i, meaning, all.size() > 1);
    }
  }
}

void TraceColumns::hint(std::size_t i, const Meaning& meaning, bool one_of_several) {
  const std::string_view unit = meaning.unit.empty()
                                    ? known_columns[index_of(meaning.base)].kind.front().suffix
                                    : meaning.unit;
  const std::string why = one_of_several           ? "so say which"
                          : !meaning.doubt.empty() ? fmt::format("but {}; say which", meaning.doubt)
                                                   : "but its name has no unit; say which";
  std::string other;
  if (meaning.base == "displacement") {
    other = fmt::format(", or --column displacement_{}={}*-1 if it falls there", unit, i + 1);
  } else if (meaning.base == "temperature") {
    other = fmt::format(", or --column ambient={}:{}", i + 1, unit);
  }
  hints_.push_back(fmt::format("column {} ('{}') {} {}, {}: --column {}={}:{}{}", i + 1, names_[i],
                               one_of_several ? "is one of several that may be the" : "may be the",
                               meaning.base, why, meaning.base, i + 1, unit,
                               meaning.doubt.empty() ? "" : other));
}

void TraceColumns::take(std::size_t i, const Meaning& meaning) {
  const std::size_t k = index_of(meaning.base);
  const Kind kind = known_columns[k].kind;
  has_[k] = true;
  targets_[i].value = k;
  targets_[i].unit = *std::ranges::find(kind, meaning.unit, &Unit::suffix);
  targets_[i].scale = meaning.scale;
  recognised_ += fmt::format("{}{} = column {} '{}' in {}", recognised_.empty() ? "" : "; ",
                             meaning.base, i + 1, names_[i], meaning.written);
}

std::string TraceColumns::own_name(std::size_t i) const {
  const Target& target = targets_[i];
  if (target.value == column_count) {
    return names_[i];
  }
  const std::string_view base = known_columns[target.value].base;
  return target.unit.suffix.empty() ? std::string(base)
                                    : fmt::format("{}_{}", base, target.unit.suffix);
}

std::size_t TraceColumns::position(Column column) const {
  if (column == Column::voltage && voltage_of_resistance_) {
    column = Column::resistance;
  }
  const auto found = std::ranges::find(targets_, static_cast<std::size_t>(column), &Target::value);
  return static_cast<std::size_t>(found - targets_.begin());
}

void TraceColumns::apply_rename(const std::string& rename) {
  const std::size_t equals = rename.find('=');
  const std::size_t star = rename.find('*', equals == std::string::npos ? 0 : equals);
  if (equals == std::string::npos || equals == 0) {
    fail(fmt::format("--column {}: must be NAME=COLUMN, NAME=COLUMN*FACTOR or QUANTITY=COLUMN:UNIT",
                     rename));
  }
  const std::string name = rename.substr(0, equals);
  const std::string column =
      rename.substr(equals + 1, star == std::string::npos ? std::string::npos : star - equals - 1);
  double factor = 1;
  if (star != std::string::npos) {
    const char* stop = rename.data() + rename.size();
    const auto [at, error] = std::from_chars(rename.data() + star + 1, stop, factor);
    if (error != std::errc{} || at != stop || !std::isfinite(factor) || factor == 0) {
      fail(fmt::format("--column {}: the factor must be a finite number, not 0", rename));
    }
  }
  if (star == std::string::npos && apply_unit(rename, name, column)) {
    return;
  }
  const auto found = find_column(column);
  if (!found) {
    fail(fmt::format("--column {}: there is no column {}{}; there are: {}", rename, column,
                     files::did_you_mean(column, names_), fmt::join(names_, ", ")));
  }
  const std::size_t i = *found;
  if (targets_[i].value != column_count) {
    fail(fmt::format("--column {}: the column has another name already", rename));
  }
  explain(i, name);
  if (targets_[i].value == column_count) {
    fail(fmt::format("--column {}: {} is no known name of a column; known are: {}", rename, name,
                     known_names()));
  }
  targets_[i].scale = factor;
}

/// The column of this name, or of this number if none has the name.
std::optional<std::size_t> TraceColumns::find_column(const std::string& column) const {
  const auto named = std::ranges::find(names_, column);
  if (named != names_.end()) {
    return static_cast<std::size_t>(named - names_.begin());
  }
  std::size_t number = 0;
  const char* const stop = column.data() + column.size();
  const auto [at, error] = std::from_chars(column.data(), stop, number);
  const bool is_number = error == std::errc{} && at == stop;
  return is_number && 0 < number && number <= names_.size() ? std::optional(number - 1)
                                                            : std::nullopt;
}

/// `current=3:mA`, `current=I:mA`: quantity, column and unit. False: the text is another form.
bool TraceColumns::apply_unit(const std::string& rename, const std::string& name,
                              const std::string& column) {
  const std::size_t colon = column.rfind(':');
  std::size_t k = index_of(name);
  if (colon == std::string::npos || k == column_count ||
      !understood(static_cast<Column>(k), options_)) {
    return false;
  }
  const auto found = find_column(column.substr(0, colon));
  if (!found) {
    return false;
  }
  const std::string unit = column.substr(colon + 1);
  constexpr auto heating = static_cast<std::size_t>(Column::heating);
  if (name == known_columns[heating].base && unit_of(name + "_" + unit, name, kind::power)) {
    if (targets_[*found].value == column_count && !has_[heating]) {
      explain(*found, name + "_" + unit);
      return true;
    }
    k = heating;
  }
  const auto meaning = meaning_of(fmt::format("{} [{}]", name, unit));
  if (!meaning || meaning->unit.empty()) {
    fail(fmt::format("--column {}: {} is no unit of {}; known are: {}", rename, unit, name,
                     names_of(known_columns[k])));
  }
  if (targets_[*found].value != column_count || has_[k]) {
    fail(
        fmt::format("--column {}: the column has another name already, or another column is the "
                    "{}",
                    rename, name));
  }
  take(*found, *meaning);
  return true;
}

std::string TraceColumns::known_names() const {
  std::vector<std::string> all;
  for (std::size_t k = 0; k < column_count; ++k) {
    const Known& column = known_columns[k];
    if (!understood(static_cast<Column>(k), options_)) {
      continue;
    }
    all.push_back(names_of(column));
  }
  return fmt::format("{}", fmt::join(all, ", "));
}

void TraceColumns::explain(std::size_t i, const std::string& name) {
  for (std::size_t k = 0; k < column_count; ++k) {
    const Known& column = known_columns[k];
    if (!understood(static_cast<Column>(k), options_)) {
      continue;
    }
    if (const auto unit = unit_of(name, column.base, column.kind)) {
      if (has_[k]) {
        fail(fmt::format("{}, column {} ({}): there is another column for {}", place_, i + 1, name,
                         column.base));
      }
      has_[k] = true;
      targets_[i].value = k;
      targets_[i].unit = *unit;
      return;
    }
    // A unit of other programs, as grams, which recognise() will take; or no unit, for its hint.
    const auto meaning = meaning_of(name);
    if (meaning && meaning->base == column.base &&
        (meaning->unit.empty() ? foreign_ && name == column.base : meaning->doubt.empty())) {
      return;
    }
    // A known quantity in an unknown unit is an error, not an unknown column. A power is allowed:
    // there are two quantities of this name, and powers of other things.
    if (column.base != "power" &&
        (name == column.base || (name.starts_with(column.base) && name[column.base.size()] == '_' &&
                                 looks_like_unit(name.substr(column.base.size() + 1))))) {
      fail(
          fmt::format("{}, column {} ({}): {} has no unit, or an unknown one; known are: {}; "
                      "or say which: --column {}={}:{}",
                      place_, i + 1, name, column.base, names_of(column), column.base, i + 1,
                      column.kind.front().suffix));
    }
  }
}

BadRow TraceColumns::out_of_range(std::size_t i, const std::string& field) const {
  const Unit& unit = targets_[i].unit;
  const Known& column = known_columns[targets_[i].value];
  std::string text = fmt::format("{} is out of range, {:.4g} to {:.4g}", field,
                                 unit.from_si(column.low), unit.from_si(column.high));
  if (!unit.suffix.empty()) {
    text += fmt::format(" {}", unit.suffix);
  } else if (column.kind.size() > 1) {
    text += fmt::format("; per cent are {}_percent", column.base);
  }
  if (column.base == "load" && field.find('.') == std::string::npos) {
    text += fmt::format(
        "; counts of a converter need their factor: --column load_N={}*NEWTONS_PER_COUNT", i + 1);
    return {i, text};
  }
  double value = 0;
  const auto [at, error] = std::from_chars(field.data() + 1, field.data() + field.size(), value);
  for (const Unit& other : column.kind) {
    const double si = other.to_si(value);
    if (error == std::errc{} && !unit.suffix.empty() && other.suffix != unit.suffix &&
        si >= column.low && si <= column.high) {
      text += fmt::format("; if it is in {}: --column {}={}:{}", other.suffix, column.base, i + 1,
                          other.suffix);
      break;
    }
  }
  return {i, text};
}

std::optional<BadRow> TraceColumns::parse(std::string_view text, TraceRow& row) const {
  row.values.fill(not_there);
  row.text = text;
  const char* at = text.data();
  const char* const stop = at + text.size();
  const std::size_t columns = targets_.size();
  for (std::size_t i = 0; i < columns; ++i) {
    const Target& target = targets_[i];
    const char* comma = nullptr;
    if (target.value == column_count) {
      comma = static_cast<const char*>(std::memchr(at, ',', static_cast<std::size_t>(stop - at)));
      comma = comma == nullptr ? stop : comma;
    } else if ((at == stop || *at == ',') &&
               may_be_empty(static_cast<Column>(target.value), options_)) {
      comma = at;
    } else {
      comma = at;
      double value = parse_number(comma, stop);
      if (!std::isfinite(value)) {
        return bad_number(i, at, stop);
      }
      value = target.unit.to_si(value * target.scale);
      const Known& column = known_columns[target.value];
      if (!(value >= column.low && value <= column.high)) {
        return out_of_range(i, field(at, stop));
      }
      row.values[target.value] = value;
    }
    const bool last = i + 1 == columns;
    if (last != (comma == stop)) {
      return BadRow{i, wrong_count(text)};
    }
    at = comma + 1;
  }
  derive_voltage(row);
  return std::nullopt;
}

std::optional<BadRow> TraceColumns::take_numbers(std::span<const double> numbers,
                                                 TraceRow& row) const {
  row.values.fill(not_there);
  row.text = {};
  for (std::size_t i = 0; i < targets_.size(); ++i) {
    const Target& target = targets_[i];
    if (target.value == column_count) {
      continue;
    }
    if (std::isnan(numbers[i]) && may_be_empty(static_cast<Column>(target.value), options_)) {
      continue;
    }
    const double value = target.unit.to_si(numbers[i] * target.scale);
    const Known& column = known_columns[target.value];
    if (!std::isfinite(value)) {
      return BadRow{i, fmt::format("'{}' is not a finite number", numbers[i])};
    }
    if (!(value >= column.low && value <= column.high)) {
      return out_of_range(i, fmt::format("'{}'", numbers[i]));
    }
    row.values[target.value] = value;
  }
  derive_voltage(row);
  return std::nullopt;
}

void TraceColumns::derive_voltage(TraceRow& row) const {
  if (voltage_of_resistance_) {
    row.values[static_cast<std::size_t>(Column::voltage)] =
        row[Column::current] * row[Column::resistance];
  }
}

std::string TraceColumns::wrong_count(std::string_view text) const {
  const auto commas = std::count(text.begin(), text.end(), ',');
  return fmt::format("the row has {} columns, the header {}", commas + 1, names_.size());
}

}  // namespace smaservo::hal
