// A tuning as text, as JSON and as settings.

#include <cmath>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <numbers>
#include <sstream>

#include "host-sim/tune/tune.hpp"
#include "model/files/message.hpp"
#include "model/files/text_table.hpp"
#include "model/files/toml/toml_fields.hpp"
#include "model/units.hpp"

namespace smaservo::tune {
namespace {

double dB(double gain) {
  return 20 * std::log10(gain);
}
double degrees(double rad) {
  return rad * 180 / std::numbers::pi;
}
double percent_of_stroke(const Tuned& t, double strain) {
  return 100 * strain / t.task.plant.wire.nominal_stroke;
}

std::string load_text(const TuneTask& task) {
  const TunedLoad& load = task.plant.load;
  return load.is_spring() ? fmt::format("a spring of {:.4g} to {:.4g} MPa over {:.3g} % of strain",
                                        1e-6 * load.low_Pa, 1e-6 * load.high_Pa, 100 * load.stroke)
                          : fmt::format("{:.4g} MPa ({:.4g} N)", 1e-6 * load.low_Pa,
                                        load.low_Pa * task.plant.wire.geometry.area_m2());
}

/// Three lines, each preceded by a mark.
std::string heading(const Tuned& t, std::string_view mark) {
  const Branches& b = t.proposal.branches;
  return fmt::format(
      "{0}{1} under {2} in air of {3:.4g} °C\n"
      "{0}contracts by {4:.2f} % up to {5:.0f} °C, stretches again in {6:.2g} s\n"
      "{0}holding takes up to {7:.3g} A, the current limit {8:.3g} V\n",
      mark, files::printable(t.wire), load_text(t.task), t.task.plant.ambient_K - zero_degC_K,
      100 * b.stroke(), b.hottest_K - zero_degC_K, b.cooling_s, t.proposal.holding_A,
      t.proposal.supply_V);
}

double in_Hz(double rad_s) {
  return rad_s / (2 * std::numbers::pi);
}

std::string settings_text(const Tuned& t) {
  files::TextTable table({{""}, {"", "{:.6g}"}, {""}});
  for (const Chosen& c : t.chosen) {
    table.add({c.path(), c.value, c.why});
  }
  return table.text();
}

std::string margins_text(const Tuned& t) {
  files::TextTable table({{"loop"},
                          {"gain margin dB", "{:.1f}"},
                          {"phase margin °", "{:.0f}"},
                          {"worst Ms", "{:.2f}"},
                          {"crosses Hz", "{:.3g}"},
                          {"answers in %", "{:.0f}"},
                          {"worst where"}});
  for (const DesignedLoop& loop : t.proposal.loops) {
    const Margins& m = loop.worst;
    if (loop.possible) {
      table.add({loop_text(loop.name), dB(m.gain), degrees(m.phase_rad), m.sensitivity,
                 in_Hz(m.crossover_rad_s), 100 * loop.answering,
                 fmt::format("{}, {:.0f} % contracted", motion_name(loop.worst_at.point.motion),
                             100 * loop.worst_at.point.share)});
    } else {
      table.add({loop_text(loop.name), {}, {}, {}, {}, {}, "does not answer to heat"});
    }
  }
  return table.text() +
         fmt::format("asked of all {} wires in all their states: {:.0f} dB, {:.0f}°, {:g}\n",
                     t.task.members, dB(AskedMargins{}.gain), degrees(AskedMargins{}.phase_rad),
                     AskedMargins{}.sensitivity);
}

files::TextTable relays(const Tuned& t) {
  files::TextTable table({{"relay test", "", "loop"},
                          {"while", "", "motion"},
                          {"wire", "", "plant"},
                          {"Hz", "{:.3g}", "Hz"},
                          {"expected", "{:.3g}", "expected_Hz"},
                          {"gain", "{:.3g}", "gain"},
                          {"expected", "{:.3g}", "expected_gain"},
                          {""},
                          {.key = "agrees"}});
  for (const RelayCheck& c : t.relays) {
    table.add({loop_text(c.name), motion_name(c.motion), c.plant, in_Hz(c.tested.rad_s),
               in_Hz(c.expected.rad_s), c.tested.gain, c.expected.gain,
               agrees(c) ? "" : "does not agree", agrees(c)});
  }
  return table;
}

std::string steps_text(const Tuned& t) {
  files::TextTable table({{"step of the strain"},
                          {"rise s", "{:.3g}"},
                          {"settles s", "{:.3g}"},
                          {"overshoot %", "{:.2f}"},
                          {"steady %", "{:.2f}"},
                          {"ripple %", "{:.2f}"},
                          {"hottest °C", "{:.1f}"}});
  const auto add = [&](const char* who, const StepResponse& s) {
    table.add({fmt::format("{:.2f} to {:.2f} %{}", 100 * s.from, 100 * s.to, who), s.rise_s,
               s.settling_s, percent_of_stroke(t, s.overshoot),
               percent_of_stroke(t, s.steady_error), percent_of_stroke(t, s.ripple),
               s.hottest_K - zero_degC_K});
  };
  for (std::size_t i = 0; i < t.worst.size(); ++i) {
    add("", t.expected.runs.front().steps[i]);
    add(", worst", t.worst[i]);
  }
  return table.text() +
         fmt::format("% of a stroke of {:g}; worst of {} wires, each number by itself\n",
                     t.task.plant.wire.nominal_stroke, t.expected.runs.size());
}

nlohmann::ordered_json step_json(const StepResponse& s) {
  return {{"from", s.from},           {"to", s.to},
          {"rise_s", s.rise_s},       {"settling_s", s.settling_s},
          {"overshoot", s.overshoot}, {"steady_error", s.steady_error},
          {"ripple", s.ripple},       {"hottest_K", s.hottest_K}};
}

nlohmann::ordered_json margins_json(const Margins& m) {
  return {{"gain_dB", dB(m.gain)},
          {"phase_deg", degrees(m.phase_rad)},
          {"sensitivity", m.sensitivity},
          {"crossover_Hz", in_Hz(m.crossover_rad_s)}};
}

}  // namespace

std::string tuned_text(const Tuned& t) {
  std::string warnings;
  for (const std::string& warning : t.warnings) {
    warnings += fmt::format("warning: {}\n", warning);
  }
  return heading(t, "") + warnings + '\n' + settings_text(t) + '\n' + margins_text(t) + '\n' +
         relays(t).text() + '\n' + steps_text(t);
}

std::string tuned_json(const Tuned& t) {
  nlohmann::ordered_json all;
  const Branches& b = t.proposal.branches;
  all["wire"] = t.wire;
  all["ambient_degC"] = t.task.plant.ambient_K - zero_degC_K;
  all["load"] = {{"low_MPa", 1e-6 * t.task.plant.load.low_Pa},
                 {"high_MPa", 1e-6 * t.task.plant.load.high_Pa},
                 {"stroke", t.task.plant.load.stroke}};
  all["expected_wire"] = {{"stroke", b.stroke()},
                          {"cooling_s", b.cooling_s},
                          {"holding_A", t.proposal.holding_A},
                          {"supply_V", t.proposal.supply_V}};
  for (const Chosen& c : t.chosen) {
    all["settings"][c.path()] = c.value;
  }
  for (const DesignedLoop& loop : t.proposal.loops) {
    if (loop.possible) {
      all["margins"][loop_text(loop.name)] = {{"answering", loop.answering},
                                              {"nominal", margins_json(loop.nominal)},
                                              {"worst", margins_json(loop.worst)}};
    }
  }
  if (!t.relays.empty()) {
    all["relay_tests"] = relays(t).json();
  }
  for (std::size_t i = 0; i < t.worst.size(); ++i) {
    all["steps"].push_back(
        {{"file", step_json(t.expected.runs.front().steps[i])}, {"worst", step_json(t.worst[i])}});
  }
  all["warnings"] = t.warnings;
  return files::json_text(all);
}

std::string tuned_toml(const Tuned& t) {
  const std::string wire =
      t.based_on.empty()
          ? "# [wire] based_on: the wire was changed with --set; name a file of it.\n"
          : fmt::format("\n[wire]\nbased_on = {}\n", files::quoted(t.based_on));
  return chosen_toml(t.chosen,
                     fmt::format("# Proposed by host-sim tune.\n{}{}", heading(t, "# "), wire));
}

}  // namespace smaservo::tune
