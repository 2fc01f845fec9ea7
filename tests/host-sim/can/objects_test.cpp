#include <cmath>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <random>
#include <utility>

#include "firmware/signals.hpp"
#include "firmware/text/signal_names.hpp"
#include "host-sim/can/bus/network.hpp"
#include "host-sim/can/positions.hpp"
#include "host-sim/can/shown.hpp"
#include "host-sim/report/text_plot.hpp"
#include "tests/host-sim/can/can_client.hpp"

namespace smaservo::can {
namespace {

using testing::HasSubstr;
using namespace std::string_literals;

TEST(CanObjects, LiveValuesHaveTwoSpellings) {
  for (std::size_t i = 0; i < signal_count; ++i) {
    const std::string name(signal_rows<double>[i].name);
    for (const std::string& spelling : {name, "live." + name}) {
      EXPECT_EQ(text::find_object(spelling).key, (Key{live_values, sub_of(i)})) << spelling;
      EXPECT_EQ(text::find_object(spelling).name, "live." + name);
      EXPECT_EQ(text::signal_row(spelling), i);
    }
    for (const Unit& unit : text::signal_kind(i)) {
      const text::KnownObject object = text::in_unit(text::find_object(name), unit);
      EXPECT_EQ(text::find_object(object.name).key, object.key) << object.name;
      EXPECT_EQ(text::find_object(object.name).unit.suffix, unit.suffix) << object.name;
    }
  }
  EXPECT_THAT(
      [] { text::find_object("wire_temperatur_K"); },
      testing::ThrowsMessage<files::UserError>(HasSubstr("did you mean wire_temperature_K")));
  EXPECT_THAT(
      [] { text::find_object("temperature_K"); },
      testing::ThrowsMessage<files::UserError>("temperature_K: is now called wire_temperature_K"));
}

TEST(CanObjects, ValuesHaveUnitsBehindThem) {
  const text::KnownObject limit = text::find_object("limits.temperature_K");
  const std::string with_sign = std::string("+120\xC2\xB0") + 'C';
  for (const std::string& text :
       {std::string("393.15"), std::string("120degC"), std::string("120 degC"),
        std::string("393.15K"), with_sign, std::string("+393.15")}) {
    EXPECT_EQ(text::value_bytes(limit, text), real_bytes(393.15F)) << text;
  }
  const text::KnownObject strain = text::find_object("limits.max_strain");
  EXPECT_EQ(text::value_bytes(strain, "4%"), real_bytes(0.04F));
  EXPECT_EQ(text::value_bytes(strain, "4percent"), real_bytes(0.04F));
  const text::KnownObject rate = text::find_object("strain.integral_1_s");
  for (const char* const text : {"2", "2 1/s", "2/s", "2 /s", "2 1_s"}) {
    EXPECT_EQ(text::value_bytes(rate, text), real_bytes(2)) << text;
  }
  EXPECT_EQ(text::value_bytes(text::find_object("6060"), "+1"), Bytes{1});
  EXPECT_THROW(text::value_bytes(text::find_object("6060"), "+-1"), files::UserError);
  for (const char* const text :
       {"120mA", "120degF", "degC", "120 degC ", "1e400K", "+-120", "++120", "+", ""}) {
    EXPECT_THAT([&] { text::value_bytes(limit, text); },
                testing::ThrowsMessage<files::UserError>(
                    HasSubstr("must be a number, or one with a unit behind it: K, degC")))
        << text;
  }
}

// The text in any unit is short, and gives the same float.
TEST(CanObjects, TextsInAnyUnitComeBack) {
  const text::KnownObject kelvin = text::find_object("limits.temperature_K");
  const text::KnownObject degree = text::find_object("limits.temperature_degC");
  EXPECT_EQ(text::value_text(degree, text::value_bytes(degree, "90")), "90");
  EXPECT_EQ(text::value_text(degree, text::value_bytes(kelvin, "300")), "26.85");
  EXPECT_EQ(text::value_text(degree, text::value_bytes(degree, "0")), "0");
  std::mt19937 random(1);
  for (const text::KnownObject& object : text::known_objects()) {
    for (const Unit& unit : object.kind) {
      const text::KnownObject other = text::in_unit(object, unit);
      const Bytes bytes = real_bytes(static_cast<float>(random() % 100'000) *
                                     std::ldexp(1.F, -static_cast<int>(random() % 10)));
      EXPECT_EQ(text::value_bytes(other, text::value_text(other, bytes)), bytes) << other.name;
    }
  }
}

TEST(CanPositions, AreReadInAnyUnitOfLength) {
  for (const char* const text : {"1000", "1mm", "1000um", "0.001m", "1 mm", "1e3", "+1000",
                                 "1000\xC2\xB5m", "1000 \xCE\xBCm"}) {
    EXPECT_EQ(position_um(text, Units::bench), 1000) << text;
  }
  EXPECT_EQ(position_um("0.0011m", Units::si), 1100);
  for (const char* const text : {"1000", "0.001", "0"}) {
    EXPECT_THAT([&] { position_um(text, Units::si); },
                testing::ThrowsMessage<files::UserError>(
                    fmt::format("position {}: needs a unit behind it: m, mm, um", text)));
  }
  EXPECT_EQ(position_um("0.8mm", Units::bench), 800);
  EXPECT_EQ(position_um("-0.3mm", Units::si), -300);
  for (std::int32_t um = -2000; um < 2000; um += 7) {
    EXPECT_EQ(position_um(fmt::format("{}mm", um / 1e3), Units::bench), um);
    EXPECT_EQ(position_um(fmt::format("{}m", um / 1e6), Units::bench), um);
  }
  const auto refused = [](const char* text, const char* why) {
    EXPECT_THAT([&] { position_um(text, Units::bench); },
                testing::ThrowsMessage<files::UserError>(HasSubstr(why)))
        << text;
  };
  refused("1inch", "must be a number, alone (um) or with a unit behind it: m, mm, um");
  refused("1degC", "with a unit behind it: m, mm, um");
  refused("mm", "must be a number");
  refused("nan", "must be");
  refused("0.5", "is 0.5 um, must be a whole number of um");
  refused("2147483648", "must be -2147483648 to 2147483647 um");
  refused("3km", "with a unit behind it");
  refused("3000m", "is 3e+09 um, must be -2147483648 to 2147483647 um");
}

TEST(CanObjects, NamesWithoutAUnitGetTheChosenOne) {
  const auto found = [](const char* name, Units units) {
    const Shown shown = shown_object(name, units);
    return std::pair(shown.object.name, shown.names_unit);
  };
  EXPECT_EQ(found("limits.current", Units::bench), std::pair("limits.current_mA"s, false));
  EXPECT_EQ(found("limits.current", Units::si), std::pair("limits.current_A"s, false));
  EXPECT_EQ(found("position", Units::bench), std::pair("live.position_um"s, false));
  EXPECT_EQ(found("limits.current_A", Units::bench), std::pair("limits.current_A"s, true));
  EXPECT_EQ(found("live.strain", Units::bench), std::pair("live.strain_percent"s, false));
  EXPECT_EQ(found("strain", Units::si), std::pair("live.strain"s, true));
  EXPECT_EQ(found("strain_percent", Units::si), std::pair("live.strain_percent"s, true));
  EXPECT_EQ(found("limits.max_strain", Units::bench), std::pair("limits.max_strain"s, true));
  EXPECT_EQ(found("setpoint", Units::bench), std::pair("live.setpoint"s, false));
  EXPECT_EQ(found("setpoint_um", Units::bench), std::pair("live.setpoint"s, true));
  EXPECT_EQ(found("6041", Units::bench), std::pair("Statusword"s, true));
  EXPECT_THROW(shown_object("limits.currnt", Units::bench), files::UserError);
  EXPECT_THROW(shown_object("setpoint_ohm", Units::bench), files::UserError);
}

TEST(CanObjects, AreFoundByNameUnitAndKey) {
  EXPECT_EQ(text::find_object("strain.proportional_W").key, gain);
  EXPECT_EQ(text::find_object("2100:1").name, "strain.proportional_W");
  EXPECT_EQ(text::find_object("0x2100:1").key, gain);
  EXPECT_EQ(text::find_object("2100h:1").key, gain);
  EXPECT_EQ(text::value_bytes(text::find_object("limits.current_mA"), "250"), real_bytes(0.25F));
  EXPECT_EQ(text::value_text(text::find_object("limits.current_mA"), real_bytes(0.25F)), "250");
  EXPECT_EQ(text::find_object("5FFF:2").type, canopen::Type::octets);
  EXPECT_THROW(text::find_object("limits.currnt_A"), files::UserError);
  EXPECT_THAT([] { text::find_object("measuring.load_gain"); },
              testing::ThrowsMessage<files::UserError>(
                  "measuring.load_gain: is now called measurement.load_gain"));
  EXPECT_THROW(text::value_bytes(text::find_object("6040"), "65536"), files::UserError);
  EXPECT_THROW(text::value_bytes(text::find_object("6060"), "-129"), files::UserError);
  EXPECT_THROW(text::value_bytes(text::find_object("limits.current_A"), "0.1x"), files::UserError);
}

// Every object reads back what it writes as text.
TEST(CanObjects, TextsComeBack) {
  for (const text::KnownObject& object : text::known_objects()) {
    const std::size_t size = canopen::size_of(object.type);
    if (size == 0) {
      continue;
    }
    const Bytes one = object.type == canopen::Type::real ? real_bytes(1.5F) : Bytes(size, 0);
    const std::string text = text::value_text(object, one);
    EXPECT_EQ(text::value_bytes(object, text), one) << object.name << ' ' << text;
  }
}

TEST(CanTextPlot, DrawsARise) {
  const std::vector<double> values{0, 1, 2, std::nan("")};
  EXPECT_EQ(report::text_plot({values}, 10, 3), "         2 |  *\n           | *\n         0 |*\n");
  EXPECT_EQ(report::text_plot({values, {2, 2, 2, 0}}, 10, 3),
            "         2 |..*\n           | *\n         0 |*  .\n");
  EXPECT_EQ(report::text_plot({}, 10, 3), "");
  // No label moves the plot to the right.
  for (const double value : {-3.64505e-07, 0.000501024, -1234567.8, 1e-300, 123456.0}) {
    EXPECT_EQ(report::text_plot({{value}}, 10, 3).find(" |"), 10U) << value;
  }
}

TEST(CanFrames, AreSaidInWords) {
  EXPECT_EQ(frame_text({.id = 0, .length = 2, .data = {1, 5}}), "NMT: start, node 5");
  EXPECT_EQ(frame_text({.id = 0x705, .length = 1, .data = {0x7F}}),
            "heartbeat of 5: pre-operational");
  EXPECT_THAT(frame_text({.id = 0x85, .length = 8, .data = {0x30, 0x81, 0x11}}),
              HasSubstr("EMCY of 5: 8130h"));
  EXPECT_THAT(frame_text({.id = 0x585, .length = 8, .data = {0x80, 0, 0x10, 0, 0, 0, 2, 6}}),
              HasSubstr("06020000h no such object"));
}

}  // namespace
}  // namespace smaservo::can
