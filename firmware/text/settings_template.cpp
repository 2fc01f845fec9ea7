#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <utility>

#include "firmware/text/settings_file.hpp"
#include "firmware/text/settings_text.hpp"
#include "model/files/toml/toml_fields.hpp"
#include "model/wire/plant.hpp"

namespace smaservo::text {
namespace {

using Row = Parameter<double>;

template <class Line>
std::string written(const Settings<double>& settings, Line line) {
  std::string out;
  std::string_view open;
  for (const Row& row : parameters<double>) {
    const std::string text = row.is_used(settings) ? line(row) : "";
    if (text.empty()) {
      continue;
    }
    if (key_parts(row).table != open) {
      open = key_parts(row).table;
      out += fmt::format("{}[{}]\n", out.empty() ? "" : "\n", open);
    }
    out += text + "\n";
  }
  return out;
}

std::string key_and_value(const Row& row, const Settings<double>& settings) {
  const std::string value = value_text(row, row.get(settings));
  return fmt::format("{} = {}", files::key_with(key_parts(row).name, row.kind.front().suffix),
                     row.type == ValueType::choice ? "\"" + value + "\"" : value);
}

/// The unit to write a parameter in: degC or MPa where that reads back to the same float, else SI.
const Unit& common_unit(const Row& row, float si) {
  for (const Unit& unit : row.kind) {
    const std::string text = fmt::format("{:.6g}", unit.from_si(static_cast<double>(si)));
    if ((unit.suffix == "degC" || unit.suffix == "MPa") &&
        static_cast<float>(unit.to_si(std::stod(text))) == si) {
      return unit;
    }
  }
  return row.kind.front();
}

/// "key = value" and its range.
std::pair<std::string, std::string> in_common_unit(const Row& row,
                                                   const Settings<double>& settings) {
  const float si = row.get(settings).real();
  const Unit& unit = common_unit(row, si);
  if (row.type != ValueType::real || unit.suffix == row.kind.front().suffix) {
    return {key_and_value(row, settings), range_text(row)};
  }
  const auto text = [&](float value) {
    return fmt::format("{:.6g}", unit.from_si(std::stod(value_text(row, Value::real(value)))));
  };
  return {fmt::format("{} = {}", files::key_with(key_parts(row).name, unit.suffix), text(si)),
          fmt::format("{} to {}", text(row.min.real()), text(row.max.real()))};
}

double two_digits(double x) {
  return std::stod(fmt::format("{:.2g}", x));
}

std::string_view change_note(Change change) {
  return change == Change::live          ? ""
         : change == Change::after_reset ? "; after a reset"
                                         : "; not while enabled";
}

}  // namespace

std::string to_toml(const Settings<double>& settings) {
  return written(settings, [&](const Row& row) { return key_and_value(row, settings); });
}

std::string settings_template(const std::string& wire) {
  const Settings<double> settings = settings_for(files::load_wire(wire).wire);
  std::string out =
      "# Settings of a device. A key may carry another unit of its kind (current_mA,\n"
      "# temperature_degC); a key that is left out has its default. The limits are those of the\n"
      "# wire's maker, in still air.\n\n";
  out += written(settings, [&](const Row& row) -> std::string {
    if (row.path.text().starts_with("wire.")) {
      return "";
    }
    const auto [line, range] = in_common_unit(row, settings);
    return fmt::format("{:<34}  # {}: {}{}", line, range, row.meaning, change_note(row.change));
  });
  return out + fmt::format(
                   "\n[wire]\nbased_on = {}  # a preset, or a file beside this one; any "
                   "number of it may be replaced below\n",
                   files::quoted(wire));
}

Settings<double> settings_for(const Wire<double>& wire) {
  Settings<double> s = default_settings<double>();
  s.wire = wire;
  const double current_A = wire.limits.current_A;
  const double ohm = cold_resistance_ohm(wire);
  s.limits.current_A = current_A;
  s.limits.temperature_K = std::min(s.limits.temperature_K, wire.limits.temperature_K);
  // A thick wire may take much more than it loses for the second that its maker rates it for.
  const double held_W = thermal_body(wire.geometry, wire.heat)
                            .loss_W(s.limits.temperature_K - s.limits.hot_spot_K - room_K);
  const double idle_A = std::sqrt(0.5 * max_idle_share * held_W / ohm);
  s.limits.min_current_A = std::min(0.1 * current_A, two_digits(idle_A));
  s.limits.power_W = two_digits(2 * current_A * current_A * ohm);
  s.limits.stress_Pa = std::min(s.limits.stress_Pa, 0.75 * wire.limits.stress_Pa);
  s.trips.current_A = 1.5 * current_A;
  s.trips.current_offset_A = 0.02 * current_A;
  s.trips.stress_Pa = std::min(s.trips.stress_Pa, wire.limits.stress_Pa);
  s.measurement.current_full_scale_A = 4 * current_A;
  s.measurement.voltage_full_scale_V =
      std::max(s.measurement.voltage_full_scale_V, 4 * current_A * ohm);
  return stored_settings<double>(s);
}

}  // namespace smaservo::text
