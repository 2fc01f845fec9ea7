// Tables as other programs write them: the same rows, whatever the dialect.

#include <cstdlib>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <random>

#include "hal/replay/sheet/layout.hpp"
#include "hal/replay/sheet/meaning.hpp"
#include "tests/hal/replay/traces.hpp"

namespace smaservo::test::sheet_test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

struct Said {
  TraceContents contents;
  std::string read_as;
  std::vector<std::string> hints;
};

Said read(std::string_view text, const hal::TraceOptions& options = {}) {
  const TemporaryFolder folder;
  hal::TraceReader reader(folder.write("trace.csv", text), options);
  Said said{read_all(reader), {}, {}};
  said.read_as = reader.read_as();
  said.hints = reader.hints();
  return said;
}

std::string utf16(std::string_view text, bool big) {
  std::string out(big ? "\xFE\xFF" : "\xFF\xFE");
  for (std::size_t i = 0; i < text.size(); ++i) {
    // What the tests write is ASCII and the sign of micro, two bytes in UTF-8.
    const bool micro = text.substr(i, 2) == "\u00B5";
    const char low = micro ? '\xB5' : text[i];
    i += micro ? 1 : 0;
    out += big ? std::string{'\0', low} : std::string{low, '\0'};
  }
  return out;
}

/// The way in which a program writes tables.
struct Dialect {
  std::string_view separator;
  char decimal;
  bool units_below, quoted, crlf, ends, repeats, trailing;
  int preface, encoding;
};

Dialect draw(std::mt19937& random) {
  constexpr std::pair<std::string_view, char> signs[] = {
      {",", '.'}, {";", '.'}, {";", ','}, {"\t", '.'}, {"\t", ','}, {"  ", '.'}, {" \t", ','}};
  const auto [separator, decimal] = signs[random() % std::size(signs)];
  const auto coin = [&] { return random() % 2 == 0; };
  const bool blank = separator.front() == ' ';
  return {separator,
          decimal,
          coin(),
          !blank && coin(),
          coin(),
          coin(),
          coin(),
          !blank && coin(),
          static_cast<int>(random() % 3),
          static_cast<int>(random() % 4)};
}

std::string written(const Dialect& d, const std::vector<std::array<double, 4>>& rows) {
  const std::string end = d.crlf ? "\r\n" : "\n";
  const auto line = [&](const std::array<std::string, 4>& fields) {
    std::string text;
    for (const std::string& field : fields) {
      text += text.empty() ? "" : std::string(d.separator);
      text += d.quoted ? '"' + field + '"' : field;
    }
    return text + (d.trailing ? std::string(d.separator) : "");
  };
  std::string text;
  constexpr std::array<std::string_view, 2> prefaces{"LabVIEW Measurement", "# made by hand"};
  for (int i = 0; i < d.preface; ++i) {
    text += std::string(prefaces[static_cast<std::size_t>(i)]) + end;
  }
  const std::string header = d.units_below ? line({"Time", "Current", "Spannung", "Force"}) + end +
                                                 line({"ms", "mA", "V", "N"})
                                           : line({"Time[ms]", "I[mA]", "Voltage(V)", "Kraft/N"});
  text += header + end;
  int n = 0;
  for (const auto& row : rows) {
    std::array<std::string, 4> fields;
    for (std::size_t k = 0; k < row.size(); ++k) {
      fields[k] = fmt::format("{}", row[k]);
      std::ranges::replace(fields[k], '.', d.decimal);
    }
    if (d.repeats && ++n == 3) {
      text += header.substr(0, header.find(end)) + end;
    }
    text += line(fields) + end;
  }
  text.erase(d.ends ? text.size() : text.size() - end.size());
  return d.encoding == 0   ? text
         : d.encoding == 1 ? "\xEF\xBB\xBF" + text
                           : utf16(text, d.encoding == 2);
}

TEST(Sheet, IsTheSameRowsInAnyDialect) {
  std::mt19937 random(41);
  for (int i = 0; i < 2000; ++i) {
    const Dialect d = draw(random);
    std::vector<std::array<double, 4>> rows;
    for (int k = 0; k < 5; ++k) {
      const auto some = [&] { return 1e-3 * static_cast<double>(random() % 100'000); };
      rows.push_back({10.0 * k + 0.5, some(), some(), some()});
    }
    const std::string text = written(d, rows);
    SCOPED_TRACE(text);
    const Said said = read(text);
    ASSERT_EQ(said.contents.rows.size(), rows.size());
    EXPECT_EQ(said.contents.skipped, 0U);
    EXPECT_THAT(said.hints, IsEmpty());
    for (std::size_t k = 0; k < rows.size(); ++k) {
      ASSERT_EQ(said.contents.at(k, hal::Column::time), rows[k][0] * 1e-3);
      ASSERT_EQ(said.contents.at(k, hal::Column::current), rows[k][1] * 1e-3);
      ASSERT_EQ(said.contents.at(k, hal::Column::voltage), rows[k][2]);
      ASSERT_EQ(said.contents.at(k, hal::Column::load), rows[k][3]);
    }
  }
}

TEST(Sheet, SaysWhatItTook) {
  EXPECT_EQ(
      read("Messung vom 28.11.\n\nTime [s];I [mA];Spannung/V;note\n0,5;100;2,5;a\n1;100;2,5;b\n")
          .read_as,
      "separated by semicolons, decimal comma, names in line 3; time = column 1 'Time [s]' in "
      "s; current = column 2 'I [mA]' in mA; voltage = column 3 'Spannung/V' in V");
  EXPECT_EQ(read("t\tU\nms\tmV\n0\t1\n1\t2\n").read_as,
            "separated by tabs, names in line 1, units in line 2; time = column 1 't [ms]' in ms; "
            "voltage = column 2 'U [mV]' in mV");
  EXPECT_EQ(read("time_s,current_A,voltage_V\n0,1,2\n1,1,2\n").read_as, "") << "our own dialect";
  EXPECT_EQ(read("time_s,U [V],current_A\n0,1,2\n1,1,2\n").read_as,
            "separated by commas, names in line 1; voltage = column 2 'U [V]' in V");
}

// What is not certain is not taken, and the option to type is named.
TEST(Sheet, DoesNotGuess) {
  const Said bare = read("time_s,U,current_A\n0,1,2\n1,1,2\n");
  EXPECT_EQ(bare.contents.rows.size(), 2U);
  EXPECT_TRUE(std::isnan(bare.contents.at(0, hal::Column::voltage)));
  ASSERT_EQ(bare.hints.size(), 1U);
  EXPECT_EQ(bare.hints[0],
            "column 2 ('U') may be the voltage, but its name has no unit; say which: --column "
            "voltage=2:V");
  const Said twice = read("time_s,U [V],Spannung (mV),current_A\n0,1,2,3\n1,1,2,3\n");
  EXPECT_TRUE(std::isnan(twice.contents.at(0, hal::Column::voltage)));
  ASSERT_EQ(twice.hints.size(), 2U);
  EXPECT_EQ(twice.hints[1],
            "column 3 ('Spannung (mV)') is one of several that may be the voltage, so say which: "
            "--column voltage=3:mV");
  EXPECT_TRUE(read("time_s,U [V],voltage_V\n0,1,2\n1,1,2\n").hints.empty())
      << "a name of our own goes first";
}

// A position may be counted either way, and a temperature be the wire's or the air's.
TEST(Sheet, SaysWhyANameIsNotEnough) {
  const Said said = read(
      "Time [s];I [A];U [V];Position [mm];Temp [\xB0"
      "C]\n0;1;2;3;20\n1;1;2;3;20\n");
  EXPECT_TRUE(std::isnan(said.contents.at(0, hal::Column::displacement)));
  EXPECT_THAT(said.hints,
              ElementsAre(HasSubstr("--column temperature=5:degC, or --column ambient=5:degC"),
                          "column 4 ('Position [mm]') may be the displacement, but whether it "
                          "grows or falls where the wire gets shorter is not told; say which: "
                          "--column displacement=4:mm, or --column displacement_mm=4*-1 if it "
                          "falls there"));
  EXPECT_THAT(said.read_as, HasSubstr("names in line 1, Latin-1"));
}

// As of a LabVIEW file: lines of the preface are like rows but for their first field.
TEST(Sheet, ReadsLabView) {
  const Said said = read(
      "LabVIEW Measurement\t\nSeparator\tTab\n***End_of_Header***\t\n\nChannels\t3\t\t\t\n"
      "Samples\t2\t2\t2\t\nX_Dimension\tTime\tTime\tTime\t\nX0\t0\t0\t0\t\nDelta_X\t0.5\t0.5\t0."
      "5\t\n"
      "***End_of_Header***\t\t\t\t\nX_Value\tVoltage_0 (V)\tCurrent_0 (mA)\tForce_0 (N)\tComment\n"
      "0\t1.5\t100\t2\n0.5\t1.6\t110\t2\n1.0\t1.7\t120\t2\n");
  EXPECT_EQ(said.contents.rows.size(), 3U);
  EXPECT_EQ(said.contents.at(1, hal::Column::time), 0.5);
  EXPECT_EQ(said.contents.at(1, hal::Column::current), 0.11);
  EXPECT_EQ(said.contents.at(1, hal::Column::voltage), 1.6);
  EXPECT_EQ(said.contents.at(1, hal::Column::load), 2);
}

TEST(Sheet, SkipsLinesThatAreNoRows) {
  const TemporaryFolder folder;
  hal::TraceReader reader(
      folder.write("t.csv",
                   "ets Jun  8 2016 00:22:57\nrst:0x1 (POWERON_RESET),boot:0x13\n"
                   "time_ms,current_mA,voltage_mV,load_gf\n0,1,2,3\n10,1,2,3\n"
                   "rst:0x10 (RTCWDT_RTC_RESET),boot\n20,1,2,3\n3\xFF,1\n30,1,2,3\n"),
      {});
  const auto contents = read_all(reader);
  EXPECT_EQ(contents.rows.size(), 4U);
  EXPECT_EQ(reader.strays(), 2U);
  EXPECT_EQ(reader.first_stray(), "line 6: 'rst:0x10 (RTCWDT_RTC_RESET),boot'");
  EXPECT_THAT(refusal("x\nt [s];U [V]\n0;1\n1;2\na\nb\nc\n", {}),
              HasSubstr("3 of 5 lines are no rows, more than half; line 5: 'a'"));
}

TEST(Sheet, AClockNeedsNoUnit) {
  const Said said = read("Time;U [V];I [A]\n16:07:05,25;1;2\n16:07:05,50;1;2\n");
  EXPECT_EQ(said.contents.at(1, hal::Column::time) - said.contents.at(0, hal::Column::time), 0.25);
  EXPECT_THAT(said.hints, IsEmpty());
}

// One name of ours does not make a table ours: its other columns are read as anybody's are.
TEST(Sheet, OneOwnNameMakesNoOwnTable) {
  const Said clock = read(
      "timestamp,current_mA,voltage_mV,load_g\n2026-11-28T16:00:00.000+01:00,12,282,45\n"
      "2026-11-28T16:00:00.020+01:00,12,282,45\n");
  EXPECT_NEAR(clock.contents.at(1, hal::Column::time) - clock.contents.at(0, hal::Column::time),
              0.02, 1e-6);
  const Said plus = read(
      "Index,Timestamp (s),Voltage (V),Current (A)\n0,0.0E+00,+2.5E+00,+1.0E-01\n"
      "1,2.0E-02,+2.5E+00,+1.0E-01\n");
  EXPECT_EQ(plus.contents.at(1, hal::Column::voltage), 2.5);
  const Said bare = read(",time,current,voltage\n0,0.5,1,2\n1,0.6,1,2\n");
  EXPECT_EQ(bare.contents.rows.size(), 2U);
  EXPECT_THAT(bare.hints,
              ElementsAre(HasSubstr("--column time=2:s"), HasSubstr("--column current=3:A"),
                          HasSubstr("--column voltage=4:V")));
  EXPECT_EQ(read("t [s]|I [A]|U [V]\n0|1|2\n1|1|2\n").contents.at(1, hal::Column::voltage), 2);
}

TEST(Sheet, ACounterThatWrapsGoesOn) {
  const TemporaryFolder folder;
  const std::string text = "micros,I_mA,U_mV\n4294947296,1,2\n4294957296,1,2\n0,1,2\n10000,1,2\n";
  hal::TraceReader reader(folder.write("t.csv", text), {});
  const auto rows = read_all(reader);
  ASSERT_EQ(rows.rows.size(), 4U);
  EXPECT_DOUBLE_EQ(rows.at(3, hal::Column::time), 4294967296e-6 + 0.01);
  ASSERT_EQ(reader.clock_notes().size(), 1U);
  EXPECT_THAT(reader.clock_notes()[0],
              HasSubstr("line 4, column 1 (micros): time 0 s does not come after 4294.957296 s; a "
                        "counter that began at 0 again goes on"));
  EXPECT_THAT(refusal("t [s],I_mA,U_mV\n4294.94,1,2\n4294.95,1,2\n0,1,2\n", {}),
              HasSubstr("does not come after"))
      << "seconds are no counter";
}

TEST(Sheet, AResistanceTellsTheVoltage) {
  for (const char* header : {"time_s,current_A,resistance_ohm", "t [s],I [A],R [Ohm]"}) {
    const Said said = read(std::string(header) + "\n0,0.5,8\n1,0.25,7.5\n");
    EXPECT_EQ(said.contents.at(0, hal::Column::voltage), 4) << header;
    EXPECT_EQ(said.contents.at(1, hal::Column::voltage), 1.875);
    EXPECT_THAT(said.read_as, HasSubstr("voltage = current times the resistance of column 3"));
  }
  EXPECT_EQ(read("time_s,current_A,voltage_V,resistance_ohm\n0,0.5,8,1\n1,0.25,7.5,1\n")
                .contents.at(0, hal::Column::voltage),
            8)
      << "where there is a voltage, it counts";
}

TEST(Sheet, ARangeNamesTheUnitThatFits) {
  EXPECT_THAT(refusal("time_s,current_A,voltage_V\n0,2500,3\n", {}),
              HasSubstr("2500' is out of range, -1000 to 1000 A; if it is in mA: --column "
                        "current=2:mA"));
}

TEST(Sheet, AColumnCanBeSaid) {
  hal::TraceOptions options;
  options.renames = {"voltage=3:mV", "current=I:uA", "time=1:min"};
  const Said said = read("a;I;b\n0;5;2500\n1;6;2600\n", options);
  EXPECT_DOUBLE_EQ(said.contents.at(1, hal::Column::voltage), 2.6);
  EXPECT_DOUBLE_EQ(said.contents.at(1, hal::Column::current), 6e-6);
  EXPECT_DOUBLE_EQ(said.contents.at(1, hal::Column::time), 60);
  options.renames = {"voltage=3:mA"};
  EXPECT_THAT(refusal("a;I;b\n0;5;2500\n1;6;2600\n", options),
              HasSubstr("mA is no unit of voltage; known are: voltage_V, voltage_mV"));
  options.renames = {"voltage=9:V"};
  EXPECT_THAT(refusal("a;I;b\n0;5;2500\n1;6;2600\n", options), HasSubstr("there is no column 9:V"));
  options.renames = {"time=1:s", "current=2:A", "voltage=3:V"};
  EXPECT_EQ(read("0 1 2\n1 3 4\n", options).contents.at(1, hal::Column::voltage), 4)
      << "without names columns have numbers";
}

TEST(Sheet, KnowsNamesAndUnits) {
  const auto is = [](std::string_view name, std::string_view base, std::string_view unit,
                     double scale = 1) {
    const auto meaning = hal::meaning_of(name);
    ASSERT_TRUE(meaning) << name;
    EXPECT_EQ(meaning->base, base) << name;
    EXPECT_EQ(meaning->unit, unit) << name;
    EXPECT_EQ(meaning->scale, scale) << name;
  };
  is("I [mA]", "current", "mA");
  is("Current (mA)", "current", "mA");
  is("Spannung/V", "voltage", "V");
  is("Voltage", "voltage", "");
  is("Force [N]", "load", "N");
  is("load_g", "load", "gf");
  is("Load cell in kg", "load", "gf", 1000);
  is("disp_um", "displacement", "um");
  is("Weg [\u00B5m]", "displacement", "um");
  is("R_ohm", "resistance", "ohm");
  is("R [\u03A9]", "resistance", "ohm");
  is("TIME (Sec)", "time", "s");
  is("millis", "time", "ms");
  is("Umgebungstemperatur [\u00B0C]", "ambient", "degC");
  for (const std::string_view name :
       {"Temperature [C]", "position_mm", "Force [MN]", "current_V", "note", "", "[A]", "/", "I [",
        "supply [V]", "Voltage divider [V]"}) {
    const auto meaning = hal::meaning_of(name);
    EXPECT_TRUE(!meaning || meaning->unit.empty() || !meaning->doubt.empty()) << name;
  }
}

TEST(Sheet, ReadsClocks) {
  const auto seconds = [](std::string_view field) { return hal::plain_number(field, '.'); };
  EXPECT_EQ(seconds("00:01:02.50"), "62.50");
  EXPECT_EQ(seconds("1970-01-02 00:00:01"), "86401");
  EXPECT_EQ(seconds("2026-11-28T12:00:00Z"), "1795867200");
  EXPECT_EQ(seconds("29.02.2024 00:00:00"), "1709164800");
  EXPECT_EQ(hal::plain_number("12:00:00,5", ','), "43200.5");
  for (const std::string_view field :
       {"11/12/2026 12:00:00", "12:60:00", "12:00", "a:00:00", "12:00:0x", "1.5.3", "0x10", "inf",
        "nan", "", "-", "1e999", "2026-13-01 00:00:00"}) {
    EXPECT_FALSE(seconds(field)) << field;
  }
}

// Neither a number that is whole nor one that lacks digits can be told in the last field of a line
// without an end; a line with too few fields can.
TEST(Sheet, ReadsZonesHalvesOfTheDayAndCertainSlashes) {
  const auto seconds = [](std::string_view field) {
    return hal::plain_number(field, '.').value_or("none");
  };
  EXPECT_EQ(seconds("12:00:00+01:00"), "39600");
  EXPECT_EQ(seconds("12:00:00.5-0230"), "52200.5");
  EXPECT_EQ(seconds("12:00:05.25 AM"), "5.25");
  EXPECT_EQ(seconds("12:00:00 pm"), "43200");
  EXPECT_EQ(seconds("4:07:05 PM"), "58025");
  EXPECT_EQ(seconds("11/28/2026 12:00:00"), seconds("2026-11-28 12:00:00"));
  EXPECT_EQ(seconds("28/11/2026 12:00:00"), seconds("2026-11-28 12:00:00"));
  EXPECT_EQ(seconds("5/5/2026 12:00:00"), seconds("2026-05-05 12:00:00"));
  for (const char* field : {"11/5/2026 12:00:00", "13:00:00 PM", "0:30:00 AM", "12:00:00+1",
                            "12:00:00 MEZ", "13/13/2026 12:00:00", "00:30:00+01:00"}) {
    EXPECT_EQ(seconds(field), "none") << field;
  }
}

TEST(Sheet, ALineThatIsCutOffIsSaid) {
  for (const std::string_view text : {"time_s,current_A\n0,1\n1", "Time [s];I [A]\n0;1\n1"}) {
    const Said said = read(text);
    EXPECT_EQ(said.contents.rows.size(), 1U);
    ASSERT_EQ(said.contents.complaints.size(), 1U);
    EXPECT_THAT(said.contents.complaints[0],
                HasSubstr("the last line has no end, so the file was cut off there"));
  }
  EXPECT_EQ(read("time_s,current_A\n0,1\n1,2").contents.rows.size(), 2U);
}

// Each line has the separator before it, so nothing has to be guessed.
TEST(Sheet, ALastColumnMayBeMostlyEmpty) {
  const TraceContents rows =
      read("t [s];I [mA];note\n0;1;at rest\n1;2;\n2;3;\n3;4;\n4;5;heated\n5;6;\n").contents;
  ASSERT_EQ(rows.rows.size(), 6U);
  EXPECT_EQ(rows.skipped, 0U);
  EXPECT_THAT(rows.texts[4], HasSubstr("heated"));
  EXPECT_EQ(read("t [s];I [mA];note\n0;1;\n1;2;\n2;3;\n").contents.rows.size(), 3U);
  EXPECT_EQ(read("t [s];I [mA];note\n0;1\n1;2\n2;3\n").contents.rows.size(), 3U) << "as LabVIEW";
}

TEST(Sheet, MessagesNameTheLineOfTheFile) {
  EXPECT_THAT(refusal("a preface\n\nt [s];I [A]\n0;1\n\n1;x\n2;3\n"),
              HasSubstr("line 6, column 2 (I [A])"));
}

// By the programs that people have.
TEST(Sheet, MayBeCompressed) {
  const TemporaryFolder folder;
  std::string text = "time_s,current_A,voltage_V\n";
  for (int i = 0; i < 100'000; ++i) {
    text += fmt::format("{},{},2\n", 0.001 * i, i % 7);
  }
  const auto compressed = [&](const std::string& program) {
    const std::string path = folder.write("t.csv", text);
    // NOLINTNEXTLINE(bugprone-command-processor): the path is the test's own
    EXPECT_EQ(std::system(fmt::format("{0} -c -q '{1}' > '{1}.x'", program, path).c_str()), 0);
    return path + ".x";
  };
  const TraceContents expected = read_trace(text);
  for (const std::string program : {"gzip", "zstd", "xz"}) {
    const std::string path = compressed(program);
    hal::TraceReader reader(path, {});
    const TraceContents contents = read_all(reader);
    EXPECT_EQ(contents.rows.size(), expected.rows.size());
    EXPECT_TRUE(contents.texts == expected.texts);
    EXPECT_EQ(reader.bytes(), reader.file_size()) << "of the file, as its progress is shown";
    // Two files one behind the other are one; a file that is cut off or damaged is refused.
    const std::string packed = file_text(path);
    hal::TraceReader twice(folder.write("twice", packed + packed), {});
    hal::TraceRow row{};
    EXPECT_THROW(while (twice.next(row)){}, hal::TraceError) << "time falls back in the second";
    EXPECT_EQ(twice.rows(), expected.rows.size());
    EXPECT_THAT(refusal(packed.substr(0, packed.size() - 9)), HasSubstr("end in the middle"));
    std::string damaged = packed;
    damaged[packed.size() - (program == "gzip" ? 6 : 1)] ^= 1;  // of the checksum, or xz's mark
    EXPECT_THAT(refusal(damaged), HasSubstr(program + " data are damaged"));
  }
  text = "t [s];I [mA]\n0;1,5\n1;2,5\n";
  hal::TraceReader reader(compressed("gzip"), {});
  EXPECT_EQ(read_all(reader).rows.size(), 2U) << "the table of another program";
  EXPECT_THAT(refusal("BZh91AY&SY"), HasSubstr("bunzip2 it first"));
}

// Whatever comes in, it is read or refused.
TEST(Sheet, NothingCrashesIt) {
  std::mt19937 random(42);
  const std::string all = "0123456789.,;\t \"\n\r#[](){}/-+:eE\xFF\xFE\xC2\xB5msVAN";
  for (int i = 0; i < 20'000; ++i) {
    std::string text(random() % 120, ' ');
    for (char& c : text) {
      c = all[random() % all.size()];
    }
    refusal(text);
  }
}

}  // namespace
}  // namespace smaservo::test::sheet_test
