#include "host-sim/choose/output.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "model/files/text_table.hpp"
#include "model/units.hpp"

namespace smaservo::choose {
namespace {

std::string name_of(const Suitable& s) {
  return choose::name_of(s.parallel, s.wire);
}

/// Three digits, without an exponent; at most so many decimals.
std::string digits(double value, int most_decimals = 3) {
  const double size = std::abs(value);
  const int decimals = size < 1e-6 ? 0 : 2 - static_cast<int>(std::floor(std::log10(size)));
  return fmt::format("{:.{}f}", value, std::clamp(decimals, 0, most_decimals));
}

/// For times that are only looked for up to a limit.
std::string time_text(const std::optional<double>& seconds, double limit_s) {
  return seconds ? digits(*seconds) : fmt::format(">{:.0f}", limit_s);
}

std::string heading(const Task& t) {
  std::string spring;
  if (t.spring) {
    spring = fmt::format("; a spring of {:.4g} N and {:.4g} N/mm", t.spring->preload_N,
                         1e-3 * t.spring->rate_N_m);
  }
  return fmt::format(
      "{:.4g} N {}, {:.4g} mm, contracted in {:.4g} s{}\n"
      "air of {:.4g} °C, a fan of {:.3g} m/s, {} cycles\n",
      t.force_N, t.one_way ? "while the wire contracts" : "of weight", 1e3 * t.stroke_m, t.time_s,
      spring, t.ambient_K - zero_degC_K, t.fan_m_s, t.life == Life::many ? "many" : "few");
}

files::TextTable table(const Choice& choice) {
  // Columns with a format are aligned to the right.
  files::TextTable table({{"wire"},
                          {"mm", "{}"},
                          {"MPa", "{}"},
                          {"mA", "{}"},
                          {"V", "{}"},
                          {"W", "{}"},
                          {"holds mA", "{}"},
                          {"°C", "{}"},
                          {"back s", "{}"},
                          {"with fan s", "{}"}});
  for (const Suitable& s : choice.suitable) {
    table.add({name_of(s), digits(1e3 * s.length_m), digits(1e-6 * s.stress_Pa),
               digits(1e3 * s.current_A), digits(s.voltage_V), digits(s.power_W),
               digits(1e3 * s.hold_A), digits(s.hottest_K - zero_degC_K),
               time_text(s.back_still_s, longest_stretch_s),
               time_text(s.back_fan_s, longest_stretch_s)});
  }
  return table;
}

std::string spring_text(const Suitable& s) {
  constexpr int decimals = 4;
  return s.spring ? digits(s.spring->preload_N, decimals) + " N + " +
                        digits(1e-3 * s.spring->rate_N_m, decimals) + " N/mm"
                  : "none";
}

/// Whether a clock would burn the wire that is off by a fifth.
bool is_quick(const Suitable& s) {
  constexpr double margin = 1.2;
  return s.overheats_s && *s.overheats_s < margin * s.seconds;
}

files::TextTable more(const Choice& choice) {
  files::TextTable table({{"wire"},
                          {"too hot after s", "{}"},
                          {"bias spring"},
                          {"maker: 1 s mA", "{}"},
                          {"maker: back s", "{}"},
                          {"cycles"}});
  const auto text = [](const std::optional<double>& value, double factor) {
    return value ? digits(factor * *value) : std::string("-");
  };
  for (const Suitable& s : choice.suitable) {
    table.add({name_of(s),
               {time_text(s.overheats_s, longest_heating_s), is_quick(s)},
               spring_text(s),
               text(s.makers_current_A, 1e3),
               text(s.makers_cooling_s, 1),
               std::string(s.cycles)});
  }
  return table;
}

std::string warnings(const Choice& choice) {
  std::string all;
  if (std::ranges::any_of(choice.suitable,
                          [](const Suitable& s) { return s.overheats_s.has_value(); })) {
    all +=
        "\nWhen a wire has contracted, switch to what holds it: with its current left on\n"
        "it becomes hotter than its limit.\n";
  }
  if (std::ranges::any_of(choice.suitable, is_quick)) {
    all +=
        "* The limit comes within a fifth of the time. End such a pulse by a measurement,\n"
        "  as smaservo does, and not by a clock.\n";
  }
  return all;
}

files::TextTable others(const Choice& choice) {
  files::TextTable table({{"not"}, {"why"}});
  for (const Unsuitable& u : choice.others) {
    table.add({u.wire, u.why});
  }
  return table;
}

std::string note(const Suitable& s) {
  return s.makers_current_A && s.makers_cooling_s
             ? fmt::format("The maker says: {:.0f} mA contract it in 1 s; it is back in {:.3g} s.",
                           1e3 * *s.makers_current_A, *s.makers_cooling_s)
             : "The maker prints no current, no time and no number of cycles.";
}

nlohmann::ordered_json number(const std::optional<double>& value) {
  return value ? nlohmann::ordered_json(*value) : nlohmann::ordered_json(nullptr);
}

/// A course with at most `most` points, the first and the last among them.
Course thinned(const Course& all, std::size_t most) {
  Course few;
  const std::size_t count = all.time_s.size();
  const std::size_t kept = std::min(most, count);
  for (std::size_t k = 0; k < kept; ++k) {
    const std::size_t i = kept == 1 ? 0 : k * (count - 1) / (kept - 1);
    few.time_s.push_back(all.time_s[i]);
    few.contraction_m.push_back(all.contraction_m[i]);
    few.temperature_K.push_back(all.temperature_K[i]);
  }
  return few;
}

/// The heating, and the cooling after it.
Course cycle(const Suitable& s, const Course& cooling) {
  constexpr std::size_t most = 100;
  Course all = thinned(s.heating, most);
  const Course end = thinned(cooling, most);
  for (std::size_t i = 0; i < end.time_s.size(); ++i) {
    all.time_s.push_back(s.seconds + end.time_s[i]);
    all.contraction_m.push_back(end.contraction_m[i]);
    all.temperature_K.push_back(end.temperature_K[i]);
  }
  return all;
}

report::Column scaled(const std::vector<double>& values, double factor, double offset = 0) {
  return report::column_of(values, [=](double v) { return factor * v - offset; });
}

files::TextTable makers_table(const std::vector<MakersCheck>& checks) {
  files::TextTable table({{"wire", "", "wire"},
                          {"maker mA", "{:.0f}", "makers_current_A", 1e3},
                          {"model mA", "{:.0f}", "current_A", 1e3},
                          {"ratio", "{:.2f}"},
                          {"maker s", "{:.3g}", "makers_cooling_s"},
                          {"model s", "{:.2f}", "cooling_s"},
                          {"ratio", "{:.2f}"}});
  for (const MakersCheck& c : checks) {
    table.add({c.wire, c.makers_current_A, c.current_A, c.current_A / c.makers_current_A,
               c.makers_cooling_s, c.cooling_s, c.cooling_s / c.makers_cooling_s});
  }
  return table;
}

}  // namespace

std::string text(const Task& task, const Choice& choice) {
  std::string all = heading(task) + '\n';
  if (choice.suitable.empty()) {
    all += "No wire of the makers' tables does it.\n";
  } else {
    all += table(choice).text() + '\n' + more(choice).text() + warnings(choice);
  }
  return choice.others.empty() ? all : all + '\n' + others(choice).text();
}

nlohmann::ordered_json json(const Choice& choice) {
  nlohmann::ordered_json wires = nlohmann::ordered_json::array();
  for (const Suitable& s : choice.suitable) {
    const Course still = cycle(s, s.still);
    const Course fan = cycle(s, s.fan);
    wires.push_back({{"wire", s.wire},
                     {"parallel", s.parallel},
                     {"length_m", s.length_m},
                     {"strain", s.strain},
                     {"stress_Pa", s.stress_Pa},
                     {"cold_stress_Pa", s.cold_stress_Pa},
                     {"current_A", s.current_A},
                     {"voltage_V", s.voltage_V},
                     {"power_W", s.power_W},
                     {"hold_current_A", s.hold_A},
                     {"hottest_K", s.hottest_K},
                     {"overheats_s", number(s.overheats_s)},
                     {"back_still_s", number(s.back_still_s)},
                     {"back_fan_s", number(s.back_fan_s)},
                     {"spring_N", s.spring ? number(s.spring->preload_N) : number({})},
                     {"spring_N_m", s.spring ? number(s.spring->rate_N_m) : number({})},
                     {"cycles", std::string(s.cycles)},
                     {"note", note(s)},
                     {"course",
                      {{"time_s", still.time_s},
                       {"contraction_m", still.contraction_m},
                       {"temperature_K", still.temperature_K},
                       {"fan_time_s", fan.time_s},
                       {"fan_contraction_m", fan.contraction_m}}}});
  }
  nlohmann::ordered_json others = nlohmann::ordered_json::array();
  for (const Unsuitable& u : choice.others) {
    others.push_back({{"wire", u.wire}, {"why", u.why}});
  }
  return {{"wires", wires}, {"others", others}};
}

std::vector<report::Panel> panels(const Task& task, const Choice& choice) {
  constexpr auto colours = std::to_array<const char*>(
      {"estimate", "reference", "planned", "heating", "#cc79a7", "measured"});
  report::Panel contraction{
      .title = "Contraction",
      .caption = fmt::format("heated for {:.3g} s, then without current; dashed: a fan of {:.3g} "
                             "m/s; at most six wires, those with the least power",
                             task.time_s, task.fan_m_s),
      .height = 320,
      .x = {.label = "time in s"},
      .y = {.label = "contraction in mm"},
      .link = "cycle"};
  report::Panel temperature{.title = "Temperature",
                            .height = 260,
                            .x = {.label = "time in s"},
                            .y = {.label = "temperature in °C"},
                            .link = "cycle"};
  const std::size_t shown = std::min(choice.suitable.size(), colours.size());
  for (std::size_t i = 0; i < shown; ++i) {
    const Suitable& s = choice.suitable[i];
    for (const bool fan : {false, true}) {
      const Course c = cycle(s, fan ? s.fan : s.still);
      const report::Column time = report::column(c.time_s);
      report::Series series{.name = name_of(s),
                            .colour = colours[i],
                            .x = time,
                            .y = scaled(c.contraction_m, 1e3),
                            .dashed = fan};
      contraction.series.push_back(series);
      series.y = scaled(c.temperature_K, 1, zero_degC_K);
      temperature.series.push_back(series);
    }
  }
  return {contraction, temperature};
}

std::string text(const std::vector<MakersCheck>& checks) {
  return makers_table(checks).text();
}

nlohmann::ordered_json json(const std::vector<MakersCheck>& checks) {
  return makers_table(checks).json();
}

}  // namespace smaservo::choose
