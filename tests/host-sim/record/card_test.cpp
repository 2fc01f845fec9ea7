// Data cards: what is right, and every kind of mistake.

#include "host-sim/record/card/card.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <regex>

#include "host-sim/record/card/card_keys.hpp"
#include "host-sim/record/card/wire_of_card.hpp"
#include "tests/host-sim/record/data_set.hpp"

namespace smaservo::record {
namespace {

using test::filled_card;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using Changes = std::vector<std::pair<std::string, std::string>>;

std::vector<std::string> faults_of(const std::string& text) {
  std::vector<std::string> faults;
  parse_card(text, "card.toml", faults);
  return faults;
}

Card card_of(const Changes& changes = {}) {
  std::vector<std::string> faults;
  Card card = parse_card(filled_card(changes), "card.toml", faults);
  EXPECT_THAT(faults, IsEmpty());
  return card;
}

std::string replaced(std::string text, const std::string& what, const std::string& by) {
  for (std::size_t at = 0; (at = text.find(what, at)) != std::string::npos; at += by.size()) {
    text.replace(at, what.size(), by);
  }
  return text;
}

TEST(Card, KeepsNumbersTheirUnitsAndWhatNobodyKnows) {
  const Card card = card_of({{"length_mm", "length_m = 0.1234"}});
  EXPECT_EQ(card.number("wire.length"), 0.1234);
  EXPECT_EQ(card.values.at("wire.length").shown, "0.1234 m");
  EXPECT_DOUBLE_EQ(*card.number("surroundings.air"), 293.15);
  EXPECT_EQ(card.number("electronics.together"), std::nullopt);
  EXPECT_TRUE(card.values.at("electronics.together").is_unknown);
  EXPECT_EQ(card.values.at("electronics.four_wire").shown, "yes");
  EXPECT_EQ(card.word("wire.preset"), "unknown");
}

TEST(Card, AnEmptyCardAsksForWhatMustBeKnownAtOnce) {
  const std::vector<std::string> faults = faults_of(empty_card());
  ASSERT_EQ(faults.size(), 2U);
  for (const CardKey& key : card_keys()) {
    const bool is_asked_for = key.is_needed && key.path != "load.force";
    EXPECT_EQ(faults[0].find(std::string(key.path)) != std::string::npos, is_asked_for) << key.path;
  }
  EXPECT_THAT(faults[1], HasSubstr("wire.diameter and wire.preset are both unknown"));
}

TEST(Card, ItsExamplesAreRight) {
  std::string text = replaced(empty_card(), "#!", "");
  text = std::regex_replace(text, std::regex("# such as (.*)\n(.*) = \"unknown\""), "$2 = $1");
  EXPECT_THAT(faults_of(text), IsEmpty()) << text;
  for (const CardKey& key : card_keys()) {
    EXPECT_THAT(text, HasSubstr(std::string(name_of(key))));
  }
}

TEST(Card, NamesEveryMistakeWithLineKeyValueAndWhatIsAllowed) {
  const std::pair<Changes, const char*> wrong[] = {
      {{{"length_mm", "length_mm = 0"}},
       "card.toml:13: wire.length_mm = 0: must be a number between 1 and 100000"},
      {{{"length_mm", "length_mm = nan"}}, "wire.length_mm = nan: must be a number between"},
      {{{"length_mm", "length_mm = \"long\""}}, "must be a number between"},
      {{{"length_mm", "length_mm = \"unknown\""}}, "must be known"},
      {{{"length_mm", "length_cm = 10"}},
       "wire.length_cm = 10: unknown key or unit; allowed: length_m, length_mm, length_um"},
      {{{"length_mm", "lenght_mm = 100"}}, "unknown key (did you mean length_mm?)"},
      {{{"length_mm", "length_mm = 100\nlength_m = 0.1"}}, "is there already as wire.length_m"},
      {{{"kind", "kind = \"gravity\""}}, "must be one of: weight, spring, machine"},
      {{{"force_N", ""}}, "missing: load.force_N;"},
      {{{"force_N", "force_N = -1"}}, "must be a number between 0 and 100000, or \"per run\""},
      {{{"kind", "kind = \"spring\""}},
       "load.force_N = 'per run': belongs only where load.kind is \"weight\"; load.kind is"},
      {{{"kind", "kind = \"spring\""}}, "missing: load.preload_N, load.rate_N_per_mm"},
      {{{"licence", "licence = \"CC-BY\""}}, "is not taken here (did you"},
      {{{"licence", "licence = \"unknown\""}}, "must be known"},
      {{{"licence", "licence = \"LicenseRef-\""}}, "is not taken here"},
      {{{"when", "when = \"2026-02-30\""}}, "must be a day as 2026-11-30"},
      {{{"when", "when = \"2026-11-30/2026-11-28\""}}, "must be a day"},
      {{{"when", "when = \"yesterday\""}}, "must be a day"},
      {{{"preset", "preset = \"smartflex-75um\""}}, "or smartflex-76um or"},
      {{{"four_wire", "four_wire = \"yes\""}}, "must be true or false; or \"unknown\""},
      {{{"four_wire", "four_wire = false"}}, "missing: electronics.lead_resistance_ohm"},
      {{{"voltage_bits", "voltage_bits = 15.5"}}, "must be a whole number between 1 and 64"},
      {{{"title", "title = \"\""}}, "must be a text of 1 to 4000 bytes"},
      {{{"title", "title = 7"}}, "must be a text in quotes"},
      {{{"air_degC", "air_degC = 293"}},
       "surroundings.air_degC = 293: must be a number between -40"},
      {{{"cold_resistance_ohm", "cold_resistance_ohm = 2200"}}, "it means 99.8 uohm_m; NiTi has"},
      {{{"diameter_um", "diameter_um = \"unknown\""}}, "are both unknown"},
      {{{"remarks", "remarks = \"none\"\n[wires]\nx = 1"}}, "unknown table (did you mean wire?)"},
      {{{"preset", "preset = \"smartflex-76um\""}, {"diameter_um", "diameter_um = 150"}},
       "wire.diameter_um = 150: smartflex-76um has 76 um; choose"},
      {{{"remarks", "remarks = "}}, "card.toml:6"},
  };
  for (const auto& [changes, said] : wrong) {
    EXPECT_THAT(faults_of(filled_card(changes)), Contains(HasSubstr(said))) << said;
  }
  EXPECT_THAT(faults_of(filled_card({{"length_mm", "length_mm = 0"}, {"by", ""}, {"when", ""}})),
              ElementsAre(HasSubstr("length_mm = 0"), HasSubstr("missing: data.by, data.when;")));
  EXPECT_THAT(faults_of(filled_card({{"title", "title = 7"},
                                     {"remarks", "remarks = 7"},
                                     {"length_mm", "length_mm = 0"},
                                     {"air_degC", "air_degC = 400"}})),
              ElementsAre(HasSubstr(":2: "), HasSubstr(":6: "), HasSubstr(":13: "),
                          HasSubstr("air_degC = 400")))
      << "in the order of the file";
  EXPECT_THAT(faults_of("wire = 3\n"), Contains(HasSubstr("must be a table: [wire]")));
  EXPECT_THAT(faults_of(""), ElementsAre(HasSubstr("missing: data.title")));
  EXPECT_THAT(faults_of(std::string(100, '\0')), Not(IsEmpty()));
}

TEST(Card, TakesADateOfToml) {
  EXPECT_EQ(card_of({{"when", "when = 2026-11-30"}}).word("data.when"), "2026-11-30");
  EXPECT_EQ(card_of({{"when", "when = \"2026-11-28/2026-11-30\""}}).word("data.when").size(), 21U);
}

TEST(Card, MakesAWireWithItsNumbers) {
  const files::WireDescription wire = wire_of(card_of({{"length_mm", "length_mm = 123.4"}}));
  EXPECT_DOUBLE_EQ(wire.wire.geometry.length_m, 0.1234);
  EXPECT_DOUBLE_EQ(wire.wire.geometry.diameter_m, 76e-6);
  const auto again = files::parse_wire(files::to_toml(wire), "wire.toml");
  EXPECT_EQ(again.wire.geometry.length_m, wire.wire.geometry.length_m);
  EXPECT_THAT(files::to_toml(wire), AllOf(HasSubstr("data card: 123.4 mm, caliper"),
                                          HasSubstr("22 ohm, four wires, 5 mA, 20 degC")));
  // All resistivities follow the card's resistance.
  const auto more = wire_of(card_of(
      {{"length_mm", "length_mm = 123.4"}, {"cold_resistance_ohm", "cold_resistance_ohm = 24.2"}}));
  EXPECT_NEAR(more.wire.material.austenite.resistivity_ohm_m /
                  wire.wire.material.austenite.resistivity_ohm_m,
              1.1, 1e-9);
}

TEST(Card, TakesTheNearestPresetWhereItKnowsNone) {
  const Changes cold{{"cold_resistance_ohm", "cold_resistance_ohm = \"unknown\""}};
  const auto preset = [&](const std::string& diameter) {
    Changes changes = cold;
    changes.emplace_back("diameter_um", "diameter_um = " + diameter);
    return preset_of(card_of(changes));
  };
  EXPECT_EQ(preset("76"), "smartflex-76um");
  EXPECT_EQ(preset("80"), "smartflex-76um");
  EXPECT_EQ(preset("149"), "smartflex-150um") << "of two with this diameter, the default family's";
  EXPECT_EQ(preset("38"), "flexinol-ht-0.038mm");
  EXPECT_EQ(preset_of(card_of({{"preset", "preset = \"flexinol-lt-0.076mm\""}})),
            "flexinol-lt-0.076mm");
  const auto wire = wire_of(card_of({{"preset", "preset = \"flexinol-lt-0.076mm\""},
                                     {"diameter_um", "diameter_um = \"unknown\""}}));
  EXPECT_DOUBLE_EQ(wire.wire.geometry.diameter_m, 76e-6);
}

}  // namespace
}  // namespace smaservo::record
