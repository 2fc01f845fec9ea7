#include "host-sim/report/panel.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <stdexcept>

namespace smaservo::report {
namespace {

/// A unit of the bench and that of SI, as labels have them.
struct UnitPair {
  std::string_view bench, si;
  Unit unit;  ///< of the bench
  bool both_ways = true;
};
constexpr std::array unit_pairs{UnitPair{"°C", "K", {"degC", 1, zero_degC_K}},
                                UnitPair{"MPa", "Pa", {"MPa", 1e6}},
                                UnitPair{"mA", "A", {"mA", 1e-3}},
                                UnitPair{"mW", "W", {"mW", 1e-3}},
                                UnitPair{"µm", "m", {"um", 1e-6}},
                                UnitPair{"mm", "m", {"mm", 1e-3}, false}};

/// How the numbers of an axis change.
struct Change {
  const UnitPair* pair = nullptr;  ///< nullptr: they do not
  bool to_si = false;

  double of(double value) const {
    return pair == nullptr ? value : to_si ? pair->unit.to_si(value) : pair->unit.from_si(value);
  }
};

constexpr std::string_view before_unit = " in ";

Change change_of(std::string_view label, Units units) {
  const std::size_t at = label.rfind(before_unit);
  if (at == std::string_view::npos) {
    return {};
  }
  const std::string_view unit = label.substr(at + before_unit.size());
  const bool to_si = units == Units::si;
  const auto* const pair = std::ranges::find_if(unit_pairs, [&](const UnitPair& one) {
    const bool moves_zero = one.unit.offset != 0;
    return to_si ? unit == one.bench
                 : unit == one.si && one.both_ways &&
                       (!moves_zero || label.starts_with("temperature"));
  });
  return pair == unit_pairs.end() ? Change{} : Change{pair, to_si};
}

/// Changes the numbers of a report's panels.
class UnitsOfPanels {
 public:
  explicit UnitsOfPanels(Units units) : units_(units) {}

  void change(std::vector<Panel>& panels) {
    // Panels refer to each other by the x axes that they share, which are as they were so far.
    std::map<std::string, Change> linked;
    for (const Panel& panel : panels) {
      linked[panel.link] = change_of(panel.x.label, units_);
    }
    for (Panel& panel : panels) {
      change(panel, linked[panel.follows]);
    }
  }

 private:
  void change(Panel& panel, const Change& followed) {
    const Change x = change_of(panel.x.label, units_);
    const Change y = change_of(panel.y.label, units_);
    const Change right = change_of(panel.right.label, units_);
    change(panel.x, x);
    change(panel.y, y);
    change(panel.right, right);
    for (Series& series : panel.series) {
      const Change along = series.right ? right : y;
      change(series.x, x);
      change(series.y, series.kind == Kind::spans ? x : along);
      change(series.low, along);
      change(series.at, followed);
    }
    for (Rule& rule : panel.rules) {
      rule.at = (rule.vertical ? x : y).of(rule.at);
    }
    for (Note& note : panel.notes) {
      note.x = x.of(note.x);
      note.y = y.of(note.y);
    }
  }

  static void change(Axis& axis, const Change& by) {
    if (by.pair == nullptr) {
      return;
    }
    axis.label = axis.label.substr(0, axis.label.rfind(before_unit) + before_unit.size()) +
                 std::string(by.to_si ? by.pair->si : by.pair->bench);
    axis.min = by.of(axis.min);
    axis.max = by.of(axis.max);
    for (auto& [at, text] : axis.ticks) {
      at = by.of(at);
    }
  }

  void change(Column& values, const Change& by) {
    if (values == nullptr || by.pair == nullptr) {
      return;
    }
    Column& changed = changed_[{values, by.pair}];
    if (changed == nullptr) {
      changed = column_of(*values, [&](double value) { return by.of(value); });
    }
    values = changed;
  }

  Units units_;
  std::map<std::pair<Column, const UnitPair*>, Column> changed_;
};

}  // namespace

std::vector<Panel> in_units(std::vector<Panel> panels, Units units) {
  UnitsOfPanels(units).change(panels);
  return panels;
}

Column column(std::vector<double> values) {
  return std::make_shared<const std::vector<double>>(std::move(values));
}

bool shows(const Column& values) {
  return std::ranges::any_of(*values, [](double value) { return std::isfinite(value); });
}

const std::vector<Role>& colours() {
  static const std::vector<Role> all{
      {"estimate", "#0059b3", "#6cb2ff"},   {"reference", "#d95f02", "#ff9a4d"},
      {"measured", "#8c8c8c", "#9aa3ad"},   {"planned", "#228833", "#5fc974"},
      {"band", "#bfd7ee", "#2c4a6b"},       {"reference_band", "#f6d5bd", "#63401f"},
      {"warning", "#ddaa33", "#e6bd5c"},    {"fault", "#b00020", "#ff6678"},
      {"heating", "#c8102e", "#ff6b6b"},    {"cooling", "#2166ac", "#6cb2ff"},
      {"martensite", "#4477aa", "#5b8fc4"}, {"r_phase", "#ddaa33", "#c9a040"},
      {"austenite", "#dd99a0", "#b5737b"},  {"ink", "#111111", "#f0f0f0"},
      {"faint", "#bbbbbb", "#5a6068"}};
  return all;
}

std::string_view on_white(std::string_view colour) {
  if (colour.starts_with('#')) {
    return colour;
  }
  const auto role = std::ranges::find(colours(), colour, &Role::name);
  if (role == colours().end()) {
    throw std::logic_error("no such colour: " + std::string(colour));
  }
  return role->light;
}

}  // namespace smaservo::report
