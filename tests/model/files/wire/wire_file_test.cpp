#include "model/files/wire/wire_file.hpp"

#include <array>
#include <bit>
#include <cmath>
#include <random>
#include <sstream>

#include "model/files/wire/presets.hpp"
#include "model/files/wire/wire_fields.hpp"
#include "tests/model/files/wire/wire_errors.hpp"

namespace smaservo::files {
namespace {

/// All numbers of a wire, to compare bit by bit.
std::vector<double> all_numbers(const Wire<double>& w) {
  std::vector<double> n{
      w.geometry.length_m,    w.geometry.diameter_m,          w.limits.current_A,
      w.limits.stress_Pa,     w.limits.temperature_K,         w.nominal_stroke,
      w.material.reference_K, w.kinetics.smallest_reversal_K, w.kinetics.loop_odds};
  const auto add = [&](const Surface<double>& s) {
    n.insert(n.end(), std::begin(s.start_K), std::end(s.start_K));
    n.insert(n.end(), std::begin(s.finish_K), std::end(s.finish_K));
    n.insert(n.end(), std::begin(s.curvature), std::end(s.curvature));
    n.insert(n.end(), std::begin(s.turning), std::end(s.turning));
    n.push_back(s.taper);
  };
  add(w.kinetics.m2a);
  add(first_surface(w.kinetics.a2m_a2r));
  add(second_surface(w.kinetics.a2m_a2r));
  add(w.kinetics.r2a);
  add(w.kinetics.r2m);
  for (const Phase<double>& p : {w.material.martensite, w.material.r_phase, w.material.austenite}) {
    n.insert(n.end(), {p.strain, p.modulus_Pa, p.resistivity_ohm_m, p.resistivity_ohm_m_K,
                       p.resistivity_ohm_m_Pa});
  }
  const HeatParams<double>& h = w.heat;
  n.insert(n.end(), {h.density_kg_m3, h.specific_heat_J_kgK, h.latent_m2a_J_kg, h.latent_r2a_J_kg,
                     h.convection_W_m2K, h.convection_W_m2K2, h.clamp_conductivity_W_mK});
  return n;
}

/// Whether the fields are in their ranges (wire_fields()), and the curves at all stresses from zero
/// to the greatest one.
testing::AssertionResult in_range(const Wire<double>& wire) {
  for (const Field* field : written_fields(wire)) {
    const std::vector<double> numbers = wire_numbers(*field, wire);
    for (const double number : numbers) {
      if (!std::isfinite(number)) {
        return testing::AssertionFailure() << field->path << " is " << number;
      }
    }
    if (field->type == FieldType::choice) {
      continue;
    }
    const double value = numbers.front();
    // Resistivities may have been scaled, which rounds them.
    const bool scaled = field->path.find(".resistivity") != std::string::npos;
    const double margin = scaled ? 1e-12 * std::abs(value) : 0;
    if (!(value >= field->min - margin && value <= field->max + margin)) {
      return testing::AssertionFailure() << field->path << " is " << value;
    }
  }
  const auto good = [&](const Isobar<double>& at, bool heating) {
    return std::isfinite(at.start_K) && (heating ? at.per_K > 0 : at.per_K < 0) &&
           std::abs(at.per_K) <= 1 && at.shape.curvature > 0 && at.shape.turning >= 0.049 &&
           at.shape.turning <= 0.951;
  };
  const auto& k = wire.kinetics;
  for (int i = 0; i <= 20; ++i) {
    const double stress_Pa = wire.limits.stress_Pa * i / 20;
    const bool all = good(isobar(k.m2a, stress_Pa), true) &&
                     good(isobar(first_surface(k.a2m_a2r), stress_Pa), false) &&
                     good(isobar(second_surface(k.a2m_a2r), stress_Pa), false) &&
                     (!k.separate_r2a || good(isobar(k.r2a, stress_Pa), true)) &&
                     (!k.separate_r2m || good(isobar(k.r2m, stress_Pa), false));
    if (!all) {
      return testing::AssertionFailure() << "a curve is out of range at " << stress_Pa << " Pa";
    }
  }
  return testing::AssertionSuccess();
}

testing::AssertionResult same_bits(const Wire<double>& a, const Wire<double>& b) {
  const std::vector<double> left = all_numbers(a);
  const std::vector<double> right = all_numbers(b);
  for (std::size_t i = 0; i < left.size(); ++i) {
    if (std::bit_cast<std::uint64_t>(left[i]) != std::bit_cast<std::uint64_t>(right[i])) {
      return testing::AssertionFailure()
             << "number " << i << ": " << testing::PrintToString(left[i]) << " became "
             << testing::PrintToString(right[i]) << ", a difference of " << right[i] - left[i];
    }
  }
  const bool same = a.kinetics.memory == b.kinetics.memory &&
                    a.kinetics.separate_r2a == b.kinetics.separate_r2a &&
                    a.kinetics.separate_r2m == b.kinetics.separate_r2m &&
                    a.material.mixture == b.material.mixture;
  return same ? testing::AssertionSuccess() : testing::AssertionFailure() << "a choice differs";
}

TEST(WireFile, EveryPresetLoadsInRange) {
  for (const std::string& name : preset_names()) {
    EXPECT_TRUE(in_range(load_wire(name).wire)) << name;
  }
}

TEST(WireFile, WritesWhatItReadsBackToTheSameBits) {
  for (const std::string& name : preset_names()) {
    const WireDescription first = load_wire(name);
    const WireDescription again = parse_wire(to_toml(first), "again.toml");
    EXPECT_TRUE(same_bits(first.wire, again.wire)) << name;
    EXPECT_EQ(again.name, first.name);
    EXPECT_EQ(again.sources, first.sources);
  }
}

TEST(WireFile, WritesNumbersAsPeopleGiveThem) {
  const std::string text = to_toml(load_wire(std::string(default_wire)));
  // In SI, 76 um and 0.1 1/GPa would not be short numbers; 0.1 m is one.
  EXPECT_THAT(text, testing::HasSubstr("\ndiameter_um = 76\n"));
  EXPECT_THAT(text, testing::HasSubstr("\nresistivity_stress_1_GPa = 0.1\n"));
  EXPECT_THAT(text, testing::HasSubstr("\nlength_m = 0.1\n"));
  WireDescription fitted = load_wire(std::string(default_wire));
  fitted.wire.geometry.length_m = 0.1 + 1e-17 * 3;
  fitted.wire.geometry.diameter_m = 76.123456789012345e-6 / 3;
  EXPECT_TRUE(same_bits(fitted.wire, parse_wire(to_toml(fitted), "again.toml").wire));
}

TEST(WireFile, WritesTheSameKeysInSiForAnyNumbers) {
  const auto keys = [](const std::string& text) {
    std::istringstream lines(text.substr(0, text.find("[sources]")));
    std::string all;
    for (std::string line; std::getline(lines, line);) {
      all += line.substr(0, line.find(" = ")) + "\n";
    }
    return all;
  };
  WireDescription wire = load_wire(std::string(default_wire));
  const std::string text = to_toml_si(wire);
  EXPECT_THAT(text, testing::HasSubstr("\ndiameter_m = "));
  EXPECT_THAT(text, testing::HasSubstr("\nresistivity_stress_1_Pa = "));
  EXPECT_TRUE(same_bits(wire.wire, parse_wire(text, "again.toml").wire));
  wire.wire.geometry.diameter_m = 76.123456789012345e-6 / 3;
  EXPECT_EQ(keys(to_toml_si(wire)), keys(text));
  EXPECT_TRUE(same_bits(wire.wire, parse_wire(to_toml_si(wire), "again.toml").wire));
}

TEST(WireFile, WritesSeparateProcessesAndChoices) {
  const WireDescription first = parse_wire(
      own_wire("wire.memory = \"plain\"\nwire.material.mixture = \"parallel\"\n"
               "[wire.r2a]\nstart_degC_by_MPa = [70, 0.12]\nfinish_degC_by_MPa = [76, 0.13]\n"
               "curvature_by_MPa = [3, 1e-3]\nturning_percent_by_MPa = [50]\n"
               "[wire.r2m]\nstart_degC_by_MPa = [40, 0.12]\nfinish_degC_by_MPa = [33, 0.12]\n"
               "curvature_by_MPa = [3]\nturning_by_MPa = [0.4, 1e-4]\n"),
      "my.toml");
  ASSERT_TRUE(first.wire.kinetics.separate_r2a && first.wire.kinetics.separate_r2m);
  EXPECT_EQ(first.wire.kinetics.memory, Memory::plain);
  EXPECT_EQ(first.wire.kinetics.smallest_reversal_K, 0);
  EXPECT_EQ(first.wire.kinetics.r2a.turning[0], 0.5);
  EXPECT_NEAR(first.wire.kinetics.r2m.turning[1], 1e-10, 1e-22);
  EXPECT_TRUE(same_bits(first.wire, parse_wire(to_toml(first), "again.toml").wire));
}

TEST(WireFile, WritesEndsAndLoopsThatAreNotPaper000s) {
  const WireDescription first = parse_wire(
      own_wire("[wire.loops]\nodds = 8\n[wire.m2a]\ntaper = 0.5\n[wire.a2r]\ntaper = 20\n"),
      "my.toml");
  const ThreePhaseParams<double>& k = first.wire.kinetics;
  EXPECT_EQ(k.loop_odds, 8);
  EXPECT_EQ(k.m2a.taper, 0.5);
  EXPECT_EQ(k.a2m_a2r.taper.first(), 0);
  EXPECT_EQ(k.a2m_a2r.taper.second(), 20);
  EXPECT_TRUE(same_bits(first.wire, parse_wire(to_toml(first), "again.toml").wire));
  EXPECT_EQ(load_wire("smartflex-76um").wire.kinetics.loop_odds, 1);
}

TEST(WireFile, WritesAnyNameAndSource) {
  WireDescription first = load_wire(std::string(default_wire));
  first.name = R"(a "quoted\ name")";
  first.sources = {{"wire.length", "a \"ruler\"\nand a \\ backslash"},
                   {"wire.heat", "µ-calorimeter"}};
  const WireDescription again = parse_wire(to_toml(first), "again.toml");
  EXPECT_EQ(again.name, first.name);
  EXPECT_EQ(std::map(again.sources.begin(), again.sources.end()),
            std::map(first.sources.begin(), first.sources.end()));
}

TEST(WireFile, UnitsAreConverted) {
  const auto length = [](const std::string& line) {
    return parse_wire(own_wire("wire." + line), "my.toml").wire.geometry.length_m;
  };
  EXPECT_DOUBLE_EQ(length("length_m = 0.12"), 0.12);
  EXPECT_DOUBLE_EQ(length("length_mm = 120"), 0.12);
  EXPECT_DOUBLE_EQ(length("length_um = 12e4"), 0.12);
  const auto m2a = [](const std::string& line) {
    return parse_wire(own_wire("wire.m2a." + line), "my.toml").wire.kinetics.m2a;
  };
  const auto by_MPa = m2a("start_degC_by_MPa = [71, 0.13, 1e-6]");
  const auto by_Pa = m2a("start_K_by_Pa = [344.15, 1.3e-7, 1e-18]");
  for (int i = 0; i < 3; ++i) {
    EXPECT_DOUBLE_EQ(by_MPa.start_K[i], by_Pa.start_K[i]);
  }
  EXPECT_DOUBLE_EQ(isobar(by_MPa, 200e6).start_K, 273.15 + 71 + 26 + 0.04);
}

TEST(WireFile, ANumberMayBeSaidInTwoWays) {
  const auto wire = [](const std::string& lines) {
    return parse_wire(own_wire(lines), "my.toml").wire;
  };
  const Wire<double> preset = wire("");
  const double area_m2 = preset.geometry.area_m2();
  EXPECT_EQ(wire("wire.limits.stress_MPa = 400").limits.stress_Pa, 400e6);
  EXPECT_EQ(wire("wire.limits.load_N = 2").limits.stress_Pa, 2 / area_m2);
  const Surface<double> steeper = wire("wire.m2a.start_1_K_MPa = 0.13").kinetics.m2a;
  EXPECT_EQ(steeper.start_K[0], preset.kinetics.m2a.start_K[0]);
  EXPECT_DOUBLE_EQ(steeper.start_K[1], 0.13e-6);
  const Phase<double> phase =
      wire("wire.austenite.resistivity_temperature_ohm_m_K = 3e-10").material.austenite;
  EXPECT_EQ(phase.resistivity_ohm_m, preset.material.austenite.resistivity_ohm_m);
  EXPECT_EQ(phase.resistivity_ohm_m_K, 3e-10);
  EXPECT_EQ(phase.resistivity_ohm_m_Pa, preset.material.austenite.resistivity_ohm_m_Pa);
}

TEST(WireFile, AProcessOfItsOwnCanBeSwitchedOff) {
  const std::string r2a =
      "[wire.r2a]\nstart_degC_by_MPa = [70, 0.12]\nfinish_degC_by_MPa = [76, 0.13]\n"
      "curvature_by_MPa = [3]\nturning_by_MPa = [0.5]\n";
  EXPECT_TRUE(parse_wire(own_wire(r2a), "my.toml").wire.kinetics.separate_r2a);
  const Wire<double> off =
      parse_wire(own_wire("wire.separate_r2a = false\n" + r2a), "my.toml").wire;
  EXPECT_TRUE(same_bits(off, load_wire(std::string(default_wire)).wire));
  EXPECT_THAT(refusal(own_wire("wire.separate_r2a = true")),
              names({"wire.r2a", "start, finish, curvature and turning"}));
}

TEST(WireFile, ItsDescriptionBuildsItAgain) {
  for (const std::string& name : preset_names()) {
    const Wire<double> wire = load_wire(name).wire;
    EXPECT_TRUE(
        same_bits(wire, build_wire(describe_wire(wire),
                                   [](std::string_view path, auto&) { ADD_FAILURE() << path; })))
        << name;
  }
}

TEST(WireFile, ResistanceOfTheColdWireScalesAllResistivities) {
  const Wire<double> before = load_wire(std::string(default_wire)).wire;
  const Wire<double> after =
      parse_wire(own_wire("wire.resistance_ohm_per_m = 240"), "my.toml").wire;
  // All resistivities are scaled by the same factor, so the ratios of the phases stay. The presets'
  // tests check the factor.
  const double scale =
      after.material.martensite.resistivity_ohm_m / before.material.martensite.resistivity_ohm_m;
  EXPECT_GT(scale, 0.9);
  EXPECT_LT(scale, 1.1);
  EXPECT_NE(scale, 1);
  const auto expect_scaled = [&](const Phase<double>& was, const Phase<double>& is) {
    EXPECT_NEAR(is.resistivity_ohm_m / was.resistivity_ohm_m, scale, 1e-12);
    EXPECT_NEAR(is.resistivity_ohm_m_K / was.resistivity_ohm_m_K, scale, 1e-12);
    EXPECT_NEAR(is.resistivity_ohm_m_Pa, was.resistivity_ohm_m_Pa * scale, 1e-30);
  };
  expect_scaled(before.material.martensite, after.material.martensite);
  expect_scaled(before.material.r_phase, after.material.r_phase);
  expect_scaled(before.material.austenite, after.material.austenite);
}

TEST(Overrides, ReplaceAKeyInAnyUnit) {
  const std::vector<Override> settings{{"wire.length_m", "0.25"},
                                       {"wire.length_mm", "300"},
                                       {"wire.memory", "plain"},
                                       {"wire.material.mixture", "\"parallel\""},
                                       {"wire.a2r.start_K_by_Pa", "[336, 1e-9]"}};
  const WireDescription d = load_wire(std::string(default_wire), settings);
  EXPECT_DOUBLE_EQ(d.wire.geometry.length_m, 0.3);  // the last one counts
  EXPECT_EQ(d.wire.kinetics.memory, Memory::plain);
  EXPECT_EQ(d.wire.material.mixture, Mixture::parallel);
  EXPECT_EQ(d.wire.kinetics.a2m_a2r.start_K[0].second(), 336);
  const std::map<std::string, std::string> sources(d.sources.begin(), d.sources.end());
  EXPECT_EQ(sources.at("wire.length"), "given with --set");
  EXPECT_EQ(sources.at("wire.a2r.start"), "given with --set");
}

TEST(WireFile, AFamilyIsNoWire) {
  for (const Preset& preset : presets()) {
    EXPECT_THAT(refusal(std::string(preset.text)), testing::HasSubstr("sizes")) << preset.family;
  }
}

TEST(Overrides, BadOnesAreRefused) {
  const auto refused = [](const std::string& key, const std::string& value) {
    return refusal(own_wire(""), {{key, value}});
  };
  EXPECT_THAT(refused("wire.length_m", "1e9"),
              names({"--set", "wire.length_m", "0.001 and 100 m", "is 1e+09"}));
  EXPECT_THAT(refused("wire.length_m", "long"),
              names({"--set", "wire.length_m", "long", "finite"}));
  EXPECT_THAT(refused("wire.length_m", ""), names({"--set", "wire.length_m", "finite"}));
  EXPECT_THAT(refused("wire.length_m", "nan"), names({"--set", "wire.length_m", "finite"}));
  EXPECT_THAT(refused("wire.length_cm", "3"), names({"--set", "wire.length_cm", "length_mm"}));
  EXPECT_THAT(refused("colour", "red"), names({"--set", "colour", "unknown"}));
  EXPECT_THAT(refused("wire.memory", "perfect"), names({"--set", "perfect", "plain"}));
  EXPECT_THAT(refused("wire.m2a.finish_degC_by_MPa", "[60]"), names({"wire.m2a", "above"}));
  EXPECT_THAT(refused("", "3"), names({"--set"}));
  EXPECT_THAT(refused("wire.", "3"), names({"--set"}));
  EXPECT_THAT(refused("a b", "3"), names({"--set"}));
}

// These keys belong to the file itself; as overrides they would have no effect.
TEST(Overrides, KeysThatAreNoNumbersAreRefused) {
  for (const char* key : {"name", "based_on", "sizes", "sources"}) {
    EXPECT_THAT(refusal(own_wire(""), {{key, "smartflex-100um"}}), names({"--set", key}));
  }
}

/// One character replaced, inserted or removed.
std::string mutated(std::string text, std::mt19937_64& random) {
  static constexpr std::string_view alphabet =
      "0123456789.-+eE_[]{}\"'=,# \n\tnaifdegCKMPmuohxyz\\\x01\x7f\xc3\xff";
  const std::size_t at = random() % text.size();
  const char with = alphabet[random() % alphabet.size()];
  switch (random() % 3) {
    case 0:
      text[at] = with;
      break;
    case 1:
      text.insert(at, 1, with);
      break;
    default:
      text.erase(at, 1);
  }
  return text;
}

TEST(WireFile, AMutatedFileLoadsInRangeOrIsRefused) {
  std::string text;
  for (const Preset& preset : presets()) {
    text = preset.family == "smartflex" ? std::string(preset.text) : text;
  }
  // Without its sizes, the family's text lacks diameter, load and current; `size` gives them.
  text.resize(text.find("[sizes."));
  const std::vector<Override> size{
      {"wire.diameter_um", "76"}, {"wire.limits.load_N", "2.7"}, {"wire.limits.current_mA", "92"}};
  std::mt19937_64 random(20240611);
  int loaded = 0;
  int refused = 0;
  for (int i = 0; i < 2000; ++i) {
    const std::string broken = mutated(text, random);
    try {
      const Wire<double> wire = parse_wire(broken, "smartflex.toml", size).wire;
      ++loaded;
      EXPECT_TRUE(in_range(wire)) << "case " << i;
    } catch (const ConfigError& error) {
      ++refused;
      EXPECT_THAT(error.what(), testing::HasSubstr("smartflex.toml")) << "case " << i;
    }
  }
  // A change in a text, comment or digit often leaves a valid file, one in the syntax does not.
  // Both must have occurred.
  EXPECT_GE(loaded, 300);
  EXPECT_GE(refused, 300);
}

}  // namespace
}  // namespace smaservo::files
