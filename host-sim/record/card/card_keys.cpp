#include "host-sim/record/card/card_keys.hpp"

#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "model/files/wrapped.hpp"

namespace smaservo::record {
namespace {

using enum CardType;

constexpr auto frequency = std::to_array<Unit>({{"Hz", 1}, {"kHz", 1e3}});
constexpr auto spring = std::to_array<Unit>({{"N_per_m", 1}, {"N_per_mm", 1e3}});

constexpr std::string_view load_kinds[] = {"weight", "spring", "machine"};
constexpr std::string_view orientations[] = {"horizontal", "vertical", "inclined"};
constexpr std::string_view movements[] = {"enclosed", "open", "fan"};

constexpr auto keys = std::to_array<CardKey>({
    {.path = "data.title",
     .type = text,
     .meaning = "which wire, what was done to it; one line",
     .example = R"("SmartFlex 76 um, 120 mm: full cycles and inner loops under four weights")",
     .is_needed = true},
    {.path = "data.by",
     .type = text,
     .meaning = "who measured: names, institute",
     .example = R"("A. Person, Institute of Wires")",
     .is_needed = true},
    {.path = "data.when",
     .type = date,
     .meaning = "day of the first run, or first and last: \"2026-11-28/2026-11-30\"",
     .example = R"("2026-11-30")"},
    {.path = "data.licence",
     .type = licence,
     .meaning = "what others may do; CC0-1.0: everything, CC-BY-4.0: everything, if they name you",
     .example = R"("CC-BY-4.0")",
     .is_needed = true},
    {.path = "data.remarks",
     .type = text,
     .meaning = "what else a stranger must know; or \"none\"",
     .example = R"("none")"},

    {.path = "wire.maker", .type = text, .meaning = "who made it", .example = R"("SAES Getters")"},
    {.path = "wire.type",
     .type = text,
     .meaning = "what the maker calls it",
     .example = R"("SmartFlex 76")"},
    {.path = "wire.alloy",
     .type = text,
     .meaning = "composition",
     .example = R"("NiTi, 54.5 % Ni by mass")"},
    {.path = "wire.batch",
     .type = text,
     .meaning = "number of the spool or batch",
     .example = R"("spool 17-0042")"},
    {.path = "wire.preset",
     .type = preset,
     .meaning = "nearest built-in wire; `host-sim wires` lists them",
     .example = R"("smartflex-76um")"},
    {.path = "wire.length",
     .type = number,
     .meaning = "between the clamps, of the cold wire",
     .example = "120",
     .is_needed = true,
     .kind = kind::length,
     .unit = "mm",
     .low = 0.001,
     .high = 100},
    {.path = "wire.length_measured",
     .type = text,
     .meaning = "how the length was measured, under which load",
     .example = R"("caliper from clamp to clamp, at 0.5 N")"},
    {.path = "wire.diameter",
     .type = number,
     .meaning = "of the bare wire; \"unknown\" only where the preset is known, which then tells it",
     .example = "76",
     .kind = kind::length,
     .unit = "um",
     .low = 5e-6,
     .high = 5e-3},
    {.path = "wire.diameter_measured",
     .type = text,
     .meaning = "how the diameter was measured",
     .example = R"("as the maker says")"},
    {.path = "wire.cold_resistance",
     .type = number,
     .meaning = "of the cold wire, without load, without leads",
     .example = "24.5",
     .kind = kind::resistance,
     .unit = "ohm",
     .low = 1e-3,
     .high = 1e6},
    {.path = "wire.cold_resistance_measured",
     .type = text,
     .meaning = "how the cold resistance was measured: temperature, current, four wires or two",
     .example = R"("at 23 degC, four wires, 5 mA")"},
    {.path = "wire.cycles",
     .type = whole,
     .meaning = "heatings and coolings before the first run",
     .example = "500",
     .kind = kind::count,
     .low = 0,
     .high = 1e9},
    {.path = "wire.history",
     .type = text,
     .meaning = "under which load and current these were, and what else it went through",
     .example = R"("500 cycles at 150 MPa, 180 mA for 3 s")"},

    {.path = "load.kind",
     .type = choice,
     .meaning = "what pulls: a weight, a spring, or a machine that makes the force or the motion",
     .example = R"("weight")",
     .is_needed = true,
     .choices = load_kinds},
    {.path = "load.force",
     .type = number,
     .meaning =
         "of a weight that is the same in all runs; else \"per run\": --load-N, or a column of the "
         "load",
     .example = "0.68",
     .is_needed = true,
     .kind = kind::force,
     .unit = "N",
     .low = 0,
     .high = 1e5,
     .only = {.path = "load.kind", .value = "weight"},
     .word = "per run"},
    {.path = "load.preload",
     .type = number,
     .meaning = "of the spring, on the cold wire",
     .example = "0.5",
     .kind = kind::force,
     .unit = "N",
     .low = 0,
     .high = 1e5,
     .only = {.path = "load.kind", .value = "spring"}},
    {.path = "load.rate",
     .type = number,
     .meaning = "of the spring; the load itself must be a column of the runs",
     .example = "0.2",
     .kind = spring,
     .unit = "N_per_mm",
     .low = 0,
     .high = 1e9,
     .only = {.path = "load.kind", .value = "spring"}},
    {.path = "load.machine",
     .type = text,
     .meaning = "which machine, and what it controls",
     .example = R"("tensile tester, force")",
     .only = {.path = "load.kind", .value = "machine"}},
    {.path = "load.measured",
     .type = text,
     .meaning = "how the load is known: load cell with full scale and step, balance",
     .example = R"("weighed on a balance, to 0.1 g")"},

    {.path = "surroundings.air",
     .type = number,
     .meaning = "temperature of the air",
     .example = "23",
     .kind = kind::temperature,
     .unit = "degC",
     .low = 233.15,
     .high = 373.15},
    {.path = "surroundings.orientation",
     .type = choice,
     .meaning = "of the wire",
     .example = R"("vertical")",
     .choices = orientations},
    {.path = "surroundings.movement",
     .type = choice,
     .meaning = "of the air: enclosed in a box, an open room, or moved by a fan",
     .example = R"("enclosed")",
     .choices = movements},
    {.path = "surroundings.fan",
     .type = number,
     .meaning = "speed of the fan's air at the wire",
     .example = "2",
     .kind = kind::velocity,
     .unit = "m_s",
     .low = 0,
     .high = 100,
     .only = {.path = "surroundings.movement", .value = "fan"}},

    {.path = "electronics.rate",
     .type = number,
     .meaning = "at which voltage and current were converted",
     .example = "1000",
     .kind = frequency,
     .unit = "Hz",
     .low = 1e-4,
     .high = 1e9},
    {.path = "electronics.current_bits",
     .type = whole,
     .meaning = "of the current's converter",
     .example = "16",
     .kind = kind::count,
     .low = 1,
     .high = 64},
    {.path = "electronics.current_full_scale",
     .type = number,
     .meaning = "of the current's converter",
     .example = "0.5",
     .kind = kind::current,
     .unit = "A",
     .low = 1e-6,
     .high = 1e3},
    {.path = "electronics.voltage_bits",
     .type = whole,
     .meaning = "of the voltage's converter",
     .example = "16",
     .kind = kind::count,
     .low = 1,
     .high = 64},
    {.path = "electronics.voltage_full_scale",
     .type = number,
     .meaning = "of the voltage's converter",
     .example = "10",
     .kind = kind::voltage,
     .unit = "V",
     .low = 1e-6,
     .high = 1e4},
    {.path = "electronics.four_wire",
     .type = flag,
     .meaning = "whether the voltage is sensed at the clamps by wires of its own, so that leads do "
                "not count",
     .example = "true"},
    {.path = "electronics.lead_resistance",
     .type = number,
     .meaning = "of the leads that the voltage was measured with",
     .example = "0.15",
     .kind = kind::resistance,
     .unit = "ohm",
     .low = 0,
     .high = 1e3,
     .only = {.path = "electronics.four_wire", .value = "false"}},
    {.path = "electronics.together",
     .type = flag,
     .meaning = "whether voltage and current are converted at the same instant; false: one after "
                "the other",
     .example = "true"},
    {.path = "electronics.filter",
     .type = text,
     .meaning = "before and behind the converters; or \"none\"",
     .example = R"("two poles at 300 Hz in both channels")"},

    {.path = "displacement.sensor",
     .type = text,
     .meaning = "type of the displacement's sensor; \"none\": there is none",
     .example = R"("laser triangulation, 10 mm range")"},
    {.path = "displacement.resolution",
     .type = number,
     .meaning = "finest step or noise of the sensor",
     .example = "1",
     .kind = kind::length,
     .unit = "um",
     .low = 1e-12,
     .high = 1,
     .only = {.path = "displacement.sensor", .value = "none", .is_not = true}},
    {.path = "displacement.zero",
     .type = text,
     .meaning = "where its zero is",
     .example = R"("the cold wire under the load, after the first cycle")",
     .only = {.path = "displacement.sensor", .value = "none", .is_not = true}},
});

constexpr auto tables = std::to_array<CardTable>({
    {"data", "Who, when, and what others may do"},
    {"wire", "The wire"},
    {"load", "How the load is made"},
    {"surroundings", "What is around the wire"},
    {"electronics", "How voltage and current are measured"},
    {"displacement", "The sensor of the displacement"},
});

constexpr std::string_view licences[] = {"CC0-1.0",        "CC-BY-4.0",    "CC-BY-SA-4.0",
                                         "CC-BY-NC-4.0",   "CC-BY-ND-4.0", "CC-BY-NC-SA-4.0",
                                         "CC-BY-NC-ND-4.0"};

std::string written_key(const CardKey& key) {
  return key.unit.empty() ? std::string(name_of(key))
                          : fmt::format("{}_{}", name_of(key), key.unit);
}

/// The comment above a key.
std::string comment_of(const CardKey& key) {
  std::string comment(key.meaning);
  if (!key.choices.empty()) {
    comment += fmt::format("; one of: {}", fmt::join(key.choices, ", "));
  }
  if (!key.only.path.empty()) {
    comment += fmt::format("; only where {} is {}\"{}\"", key.only.path,
                           key.only.is_not ? "not " : "", key.only.value);
  }
  const std::string mark = "# ";
  return mark + fmt::format("{}\n",
                            fmt::join(files::broken(comment, files::terminal_columns - mark.size()),
                                      "\n" + mark));
}

}  // namespace

std::span<const CardKey> card_keys() {
  return keys;
}

std::span<const CardTable> card_tables() {
  return tables;
}

std::span<const std::string_view> known_licences() {
  return licences;
}

std::string_view table_of(const CardKey& key) {
  return key.path.substr(0, key.path.find('.'));
}

std::string_view name_of(const CardKey& key) {
  return key.path.substr(key.path.find('.') + 1);
}

std::string empty_card() {
  std::string text =
      "# Data card of runs of a wire: what a stranger must know to use them.\n"
      "# Replace each \"unknown\" by what you know; the examples show how. Where you do not\n"
      "# know, leave \"unknown\"; readers will see it. Lines that begin with #! must be\n"
      "# filled in, since a replay or the right to use the data depends on them: remove\n"
      "# the #! there. A number's unit is the end of its name: length_mm may also be\n"
      "# length_m or length_um.\n";
  for (const CardTable& table : tables) {
    text += fmt::format("\n# {}.\n[{}]\n", table.meaning, table.name);
    for (const CardKey& key : keys) {
      if (table_of(key) != table.name) {
        continue;
      }
      const bool is_optional = !key.only.path.empty() && !key.only.is_not;
      text += comment_of(key);
      text += key.is_needed ? fmt::format("#!{} = {}\n", written_key(key), key.example)
              : is_optional ? fmt::format("#{} = {}\n", written_key(key), key.example)
                            : fmt::format("# such as {}\n{} = \"{}\"\n", key.example,
                                          written_key(key), unknown_word);
    }
  }
  return text;
}

}  // namespace smaservo::record
