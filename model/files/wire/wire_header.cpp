#include "model/files/wire/wire_header.hpp"

#include <array>
#include <fmt/format.h>
#include <span>

#include "model/files/message.hpp"

namespace smaservo::files {
namespace {

/// A name that no word of the language is, with one underscore for what no name may have.
std::string identifier(const std::string& name) {
  std::string text = "wire_";
  for (const char c : name) {
    const bool usual = ('a' <= c && c <= 'z') || ('A' <= c && c <= 'Z') || ('0' <= c && c <= '9');
    if (usual) {
      text += c;
    } else if (text.back() != '_') {
      text += '_';
    }
  }
  while (text.ends_with('_')) {
    text.pop_back();
  }
  return text;
}

/// In quotes, so that no backslash is the line's last sign and goes on in the next line.
std::string remark(const std::string& text) {
  return fmt::format("\"{}\"", printable(text));
}

/// The shortest literal of the type double that is this value.
std::string number(double value) {
  std::string text = fmt::format("{}", value);
  if (text.find_first_of(".en") == std::string::npos) {
    text += ".0";
  }
  return "S(" + text + ")";
}

std::string list(std::span<const double> values) {
  std::string text;
  for (const double value : values) {
    text += (text.empty() ? "" : ", ") + number(value);
  }
  return "{" + text + "}";
}

std::string surface(const Surface<double>& s) {
  return fmt::format("{{{}, {}, {}, {}, {}}}", list(s.start_K), list(s.finish_K), list(s.curvature),
                     list(s.turning), number(s.taper));
}

std::string phase(const Phase<double>& p) {
  return list(std::array{p.strain, p.modulus_Pa, p.resistivity_ohm_m, p.resistivity_ohm_m_K,
                         p.resistivity_ohm_m_Pa});
}

std::string kinetics(const ThreePhaseParams<double>& k) {
  return fmt::format(
      R"({{.m2a = {},
                   .a2m_a2r = pair_surfaces<S>({},
                                               {}),
                   .r2a = {},
                   .r2m = {},
                   .separate_r2a = {},
                   .separate_r2m = {},
                   .memory = Memory::{},
                   .smallest_reversal_K = {},
                   .loop_odds = {}}})",
      surface(k.m2a), surface(first_surface(k.a2m_a2r)), surface(second_surface(k.a2m_a2r)),
      k.separate_r2a ? surface(k.r2a) : "{}", k.separate_r2m ? surface(k.r2m) : "{}",
      k.separate_r2a, k.separate_r2m, k.memory == Memory::plain ? "plain" : "return_point",
      number(k.smallest_reversal_K), number(k.loop_odds));
}

}  // namespace

std::string to_header(const WireDescription& description) {
  const Wire<double>& w = description.wire;
  const Material<double>& m = w.material;
  const HeatParams<double>& h = w.heat;
  std::string out = fmt::format(
      "#pragma once\n"
      "// A wire by name {}, made by `host-sim describe wire --as header`. In SI.\n",
      remark(description.name));
  for (const auto& [key, text] : description.sources) {
    out += fmt::format("//   {}: {}\n", remark(key), remark(text));
  }
  out += fmt::format(
      R"(
#include <smaservo/model/wire/wire.hpp>

template <class S>
smaservo::Wire<S> {}() {{
  using namespace smaservo;
  return {{
      .geometry = {{.length_m = {}, .diameter_m = {}}},
      .limits = {{.current_A = {}, .stress_Pa = {}, .temperature_K = {}}},
      .nominal_stroke = {},
      .kinetics = {},
      .material = {{.martensite = {},
                   .r_phase = {},
                   .austenite = {},
                   .reference_K = {},
                   .mixture = Mixture::{}}},
      .heat = {{.density_kg_m3 = {},
               .specific_heat_J_kgK = {},
               .latent_m2a_J_kg = {},
               .latent_r2a_J_kg = {},
               .convection_W_m2K = {},
               .convection_W_m2K2 = {},
               .clamp_conductivity_W_mK = {}}},
      .accuracy = {{.strain = {}, .resistance = {}}},
  }};
}}
)",
      identifier(description.name), number(w.geometry.length_m), number(w.geometry.diameter_m),
      number(w.limits.current_A), number(w.limits.stress_Pa), number(w.limits.temperature_K),
      number(w.nominal_stroke), kinetics(w.kinetics), phase(m.martensite), phase(m.r_phase),
      phase(m.austenite), number(m.reference_K),
      m.mixture == Mixture::series ? "series" : "parallel", number(h.density_kg_m3),
      number(h.specific_heat_J_kgK), number(h.latent_m2a_J_kg), number(h.latent_r2a_J_kg),
      number(h.convection_W_m2K), number(h.convection_W_m2K2), number(h.clamp_conductivity_W_mK),
      number(w.accuracy.strain), number(w.accuracy.resistance));
  return out;
}

}  // namespace smaservo::files
