#include "host-sim/can/watch.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <optional>

#include "firmware/canopen/node/index.hpp"
#include "firmware/signals.hpp"
#include "host-sim/can/shown.hpp"
#include "host-sim/report/text_plot.hpp"
#include "model/files/text_table.hpp"

namespace smaservo::can {
namespace {

constexpr std::size_t plot_width = 64;
constexpr std::size_t plot_height = 12;

constexpr std::array<const char*, 8> usual{
    "6041",       "live.position",   "live.setpoint", "live.wire_temperature", "live.drive_current",
    "live.power", "live.resistance", "live.stress"};

constexpr Key statusword{canopen::index::statusword, 0};

/// A value that was read.
struct Reading {
  text::KnownObject object;  ///< in the unit of the reading
  Bytes bytes;
  bool unit_is_known = true;
};

/// The meaning of a code, in words.
std::string words_of(const Reading& reading) {
  if (reading.object.key == statusword) {
    return fmt::format(
        "  {}", drive_state_text(static_cast<unsigned>(canopen::take_number(reading.bytes))));
  }
  return reading.unit_is_known ? "" : fmt::format("  {}", unknown_mode);
}

/// The value with the digits that a table needs.
std::string table_text(const Reading& reading) {
  const bool live = reading.object.key.index == live_values;
  return live ? fmt::format("{:.5g}", reading.object.unit.from_si(
                                          text::value_number(reading.object, reading.bytes)))
              : text::value_text(reading.object, reading.bytes);
}

/// What a table says of a position loop without gains; "" where there is nothing to say.
std::string loop_text(Remote& remote, const std::optional<Kind>& mode) {
  if (!mode || mode->front().suffix != kind::length.front().suffix) {
    return "";
  }
  try {
    // The other gains are factors of this one: the loop is without effect whatever they are.
    return remote.number("strain.proportional_W") == 0
               ? "strain.proportional_W is 0, its default: the model alone drives\n"
               : "";
  } catch (const SdoError& error) {
    if (error.code() == 0) {
      throw;
    }
    return "";
  }
}

/// The index of the object to plot, which is added if it is missing; if there is none to plot, the
/// number of objects.
std::size_t place_of_plot(const WatchPlan& plan, std::vector<Shown>& all) {
  if (plan.plot.empty()) {
    return all.size();
  }
  const Shown wanted = shown_object(plan.plot, plan.units);
  const auto found = std::ranges::find_if(all, [&](const Shown& one) {
    return one.object.key == wanted.object.key && one.object.name == wanted.object.name &&
           one.typed_unit == wanted.typed_unit;
  });
  const auto place = static_cast<std::size_t>(found - all.begin());
  if (place == all.size()) {
    all.push_back(wanted);
  }
  return place;
}

std::string table(const std::vector<Reading>& row) {
  files::TextTable table({{""}, {""}});
  for (const Reading& reading : row) {
    table.add({reading.object.name, table_text(reading) + words_of(reading)});
  }
  return table.text();
}

/// Lines of CSV; the unit of each column stays what it is in the header.
class CsvLines {
 public:
  CsvLines(const std::vector<Shown>& all, const std::optional<Kind>& mode, Units units) {
    for (const Shown& one : all) {
      columns_.push_back(in_force(one, mode, units));
    }
  }

  std::string header() const {
    std::string text = "time_s";
    for (const text::KnownObject& column : columns_) {
      text += "," + column.name;
    }
    return text + '\n';
  }

  /// `remark` is told of a column that has to stay empty.
  std::string line(double time_s, const std::vector<Reading>& row,
                   const std::function<void(const std::string&)>& remark) {
    std::string text = fmt::format("{:.3f}", time_s);
    for (std::size_t i = 0; i < row.size(); ++i) {
      const text::KnownObject& column = columns_[i];
      // A column that began without a known mode has SI numbers of whatever mode.
      const bool fits = column.unit.suffix.empty() || row[i].object.name == column.name;
      text += "," + (fits ? text::value_text(column, row[i].bytes) : "");
      if (!fits && !told_) {
        told_ = true;
        remark(fmt::format("{}: empty while the mode has another unit, first at {:.3f} s\n",
                           column.name, time_s));
      }
    }
    return text + '\n';
  }

 private:
  std::vector<text::KnownObject> columns_;
  bool told_ = false;
};

/// The values of one object over the last rows, drawn as text.
class Plot {
 public:
  /// `place`: the index of the object among those that are read.
  explicit Plot(std::size_t place) : place_(place) {}

  void add(const std::vector<Reading>& row) {
    if (place_ >= row.size()) {
      return;
    }
    const Reading& reading = row[place_];
    if (reading.object.name != name_) {
      // The unit has changed.
      history_.clear();
      name_ = reading.object.name;
    }
    history_.push_back(
        reading.object.unit.from_si(text::value_number(reading.object, reading.bytes)));
    if (history_.size() > plot_width) {
      history_.erase(history_.begin());
    }
  }

  /// "" where nothing is drawn.
  std::string text() const {
    return history_.empty()
               ? ""
               : "\n" + name_ + "\n" + report::text_plot({history_}, plot_width, plot_height);
  }

 private:
  std::size_t place_;
  std::string name_;
  std::vector<double> history_;
};

std::vector<Shown> shown_of(const WatchPlan& plan) {
  std::vector<Shown> all;
  for (const std::string& name :
       plan.names.empty() ? std::vector<std::string>(usual.begin(), usual.end()) : plan.names) {
    all.push_back(shown_object(name, plan.units));
  }
  return all;
}

std::vector<Reading> read_row(Remote& remote, const std::vector<Shown>& all,
                              const std::optional<Kind>& mode, Units units) {
  std::vector<Reading> row;
  for (const Shown& one : all) {
    const text::KnownObject object = in_force(one, mode, units);
    row.push_back({object, remote.read(object), !one.by_mode || mode});
  }
  return row;
}

}  // namespace

void watch(Remote& remote, const WatchPlan& plan, bool in_place,
           const std::function<void(const std::string&)>& show,
           const std::function<void(const std::string&)>& remark) {
  std::vector<Shown> all = shown_of(plan);
  Plot plot(place_of_plot(plan, all));
  const bool by_mode = std::ranges::any_of(all, &Shown::by_mode);
  const auto mode_now = [&] { return in_place || by_mode ? kind_in_force(remote) : std::nullopt; };
  const std::optional<Kind> first_mode = mode_now();
  for (const Shown& one : all) {
    require_in_force(one, first_mode);
  }
  CsvLines csv(all, first_mode, plan.units);
  if (!in_place) {
    show(csv.header());
  }
  if (!in_place && by_mode && !first_mode) {
    remark(fmt::format("set-point and reference: {}\n", unknown_mode));
  }
  const std::int64_t start_us = remote.bus().now_us();
  const auto period_us = static_cast<std::int64_t>(plan.period_s * 1e6);
  for (std::uint64_t i = 0; plan.count == 0 || i < plan.count; ++i) {
    hal::CanFrame passing;
    while (remote.bus().receive(passing, start_us + static_cast<std::int64_t>(i) * period_us)) {
    }
    const double time_s = static_cast<double>(remote.bus().now_us() - start_us) * 1e-6;
    const std::optional<Kind> mode = mode_now();
    const std::vector<Reading> row = read_row(remote, all, mode, plan.units);
    plot.add(row);
    if (in_place) {
      show(table(row) + loop_text(remote, mode) + plot.text());
    } else {
      show(csv.line(time_s, row, remark) + (i + 1 == plan.count ? plot.text() : ""));
    }
  }
}

}  // namespace smaservo::can
