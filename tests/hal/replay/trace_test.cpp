#include "hal/replay/trace.hpp"

#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "model/units.hpp"
#include "tests/hal/replay/traces.hpp"

namespace smaservo::test::trace_test {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::StartsWith;

constexpr const char* plain = "time_s,current_A,voltage_V\n0,0.1,2\n0.5,0.2,4\n1,0.3,6\n";

hal::TraceOptions lenient() {
  hal::TraceOptions options;
  options.lenient = true;
  return options;
}
hal::TraceOptions renamed(std::vector<std::string> renames) {
  hal::TraceOptions options;
  options.renames = std::move(renames);
  return options;
}

TEST(TraceHeader, UnitsAreConvertedToSi) {
  const TraceContents t = read_trace(
      "time_ms,current_mA,voltage_mV,load_gf,stress_MPa,temperature_degC,ambient_K,"
      "strain_ref_percent,displacement_um\n1500,250,1200,1000,150,-3.15,300,4,2500\n");
  EXPECT_DOUBLE_EQ(t.at(0, hal::Column::time), 1.5);
  EXPECT_DOUBLE_EQ(t.at(0, hal::Column::current), 0.25);
  EXPECT_DOUBLE_EQ(t.at(0, hal::Column::voltage), 1.2);
  EXPECT_DOUBLE_EQ(t.at(0, hal::Column::load), 9.80665);
  EXPECT_DOUBLE_EQ(t.at(0, hal::Column::stress), 150e6);
  EXPECT_DOUBLE_EQ(t.at(0, hal::Column::temperature), 270);
  EXPECT_DOUBLE_EQ(t.at(0, hal::Column::ambient), 300);
  EXPECT_DOUBLE_EQ(t.at(0, hal::Column::strain_ref), 0.04);
  EXPECT_DOUBLE_EQ(t.at(0, hal::Column::displacement), 2.5e-3);
}

TEST(TraceHeader, OrderDoesNotMatter) {
  const TraceContents t = read_trace("voltage_V,time_s,current_A\n2,0,0.1\n4,0.5,0.2\n6,1,0.3\n");
  const TraceContents expected = read_trace(plain);
  ASSERT_EQ(t.rows.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) {
    for (const hal::Column column :
         {hal::Column::time, hal::Column::current, hal::Column::voltage}) {
      EXPECT_EQ(t.at(i, column), expected.at(i, column));
    }
  }
}

TEST(TraceHeader, WhatIsNotThereIsNotANumber) {
  const TraceContents t = read_trace(plain);
  for (const hal::Column column :
       {hal::Column::load, hal::Column::stress, hal::Column::temperature, hal::Column::ambient,
        hal::Column::strain_ref, hal::Column::displacement}) {
    EXPECT_TRUE(std::isnan(t.at(0, column)));
  }
}

TEST(TraceHeader, ByteOrderMarkSpacesAndCarriageReturnsAreNotPartOfNames) {
  const TemporaryFolder folder;
  hal::TraceReader reader(folder.write("t.csv",
                                       "\xEF\xBB\xBF time_s ,\tcurrent_A, voltage_V\t,note \r\n"
                                       "0,0.1,2,x\r\n0.5,0.2,4,y z\r\n"),
                          {});
  EXPECT_THAT(reader.names(), ElementsAre("time_s", "current_A", "voltage_V", "note"));
  const TraceContents t = read_all(reader);
  EXPECT_EQ(t.at(1, hal::Column::voltage), 4);
  EXPECT_THAT(t.texts, ElementsAre("0,0.1,2,x", "0.5,0.2,4,y z"));
}

TEST(TraceHeader, UnknownColumnsAreKeptAsText) {
  const TemporaryFolder folder;
  hal::TraceReader reader(
      folder.write("t.csv", "note,time_s,temperature_ref_degC,\n,1,nan,\nnan,2,<&,text\n"), {});
  EXPECT_THAT(reader.unknown(), ElementsAre(0U, 2U, 3U));
  EXPECT_TRUE(reader.has(hal::Column::time));
  EXPECT_FALSE(reader.has(hal::Column::temperature));
  EXPECT_THAT(read_all(reader).texts, ElementsAre(",1,nan,", "nan,2,<&,text"));
}

TEST(TraceHeader, ResistanceAndPowerAreTextUnlessAskedFor) {
  const std::string text = "time_s,resistance_mohm,power_mW_per_mg,power_W\n0,20500,,\n";
  const TraceContents kept = read_trace(text);
  EXPECT_THAT(kept.texts, ElementsAre("0,20500,,"));
  EXPECT_TRUE(std::isnan(kept.at(0, hal::Column::resistance)));
  EXPECT_EQ(read_trace("resistance_kohm,power\nx,y\n").rows.size(), 1U);

  hal::TraceOptions options;
  options.resistance_and_power = true;
  EXPECT_THAT(refusal(text, options), StartsWith("line 2, column 3 (power_mW_per_mg): "));
  const TraceContents read =
      read_trace("resistance_mohm,power_mW_per_mg,power_W\n20500,-0.2,x\n", options);
  EXPECT_DOUBLE_EQ(read.at(0, hal::Column::resistance), 20.5);
  EXPECT_DOUBLE_EQ(read.at(0, hal::Column::power), -200);
  EXPECT_THAT(refusal("resistance_S\n", options), HasSubstr("resistance_mohm"));
  EXPECT_EQ(refusal("power_W\n1\n", options), "") << "not specific: another quantity";
}

TEST(TraceHeader, DuplicatesAreRefused) {
  EXPECT_THAT(refusal("time_s,current_A,current_mA\n"),
              AllOf(StartsWith("line 1, column 3 (current_mA): "), HasSubstr("current")));
  EXPECT_THAT(refusal("time_s,load_N,time_s\n"), StartsWith("line 1, column 3 (time_s): "));
}

TEST(TraceHeader, ForeignUnitsAreRefused) {
  const std::pair<std::string, const char*> foreign[] = {{"time", "time_us"},
                                                         {"time_h", "time_us"},
                                                         {"current", "current_mA"},
                                                         {"current_kA", "current_mA"},
                                                         {"load_oz", "load_gf"},
                                                         {"stress_bar", "stress_kPa"},
                                                         {"temperature_degF", "temperature_degC"},
                                                         {"displacement_ft", "displacement_um"}};
  for (const auto& [name, known] : foreign) {
    EXPECT_THAT(refusal("note," + name + "\n"),
                AllOf(StartsWith("line 1, column 2 (" + name + "): "), HasSubstr(known)));
  }
}

TEST(TraceHeader, EmptyFilesAndFoldersAreRefused) {
  EXPECT_THAT(refusal(""), HasSubstr("is empty"));
  const TemporaryFolder folder;
  EXPECT_THROW(hal::TraceReader(folder.path().string(), {}), hal::TraceError);
  EXPECT_THROW(hal::TraceReader(folder / "missing.csv", {}), hal::TraceError);
}

TEST(TraceHeader, AHeaderAloneHasNoRows) {
  EXPECT_EQ(read_trace("time_s,current_A\n").rows.size(), 0U);
  EXPECT_EQ(read_trace("time_s,current_A").rows.size(), 0U);
}

TEST(TraceRename, GivesAColumnAnotherNameAndFactor) {
  const std::string text = "step,I,current_A,voltage_V\n0,1,3,5\n2,2,4,6\n";
  const TraceContents t = read_trace(text, renamed({"time_s=step*5", "load_mN=I*-2e1"}));
  EXPECT_DOUBLE_EQ(t.at(1, hal::Column::time), 10);
  EXPECT_DOUBLE_EQ(t.at(1, hal::Column::load), -0.04);
  EXPECT_DOUBLE_EQ(t.at(1, hal::Column::current), 4);
}

TEST(TraceRename, FactorComesBeforeTheUnit) {
  const TraceContents t = read_trace("T\n20\n", renamed({"temperature_degC=T*2"}));
  EXPECT_DOUBLE_EQ(t.at(0, hal::Column::temperature), zero_degC_K + 40);
}

TEST(TraceRename, TakesAwayAMeaning) {
  const TraceContents t = read_trace("current_A,set\n1,2\n", renamed({"voltage_V=current_A"}));
  EXPECT_EQ(t.at(0, hal::Column::voltage), 1);
  EXPECT_TRUE(std::isnan(t.at(0, hal::Column::current)));
}

TEST(TraceRename, MistakesAreNamed) {
  const std::string text = "step,I,current_A\n0,1,3\n1,2,4\n";
  for (const char* rename :
       {"time_s", "=step", "time_s=step*", "time_s=step*x", "time_s=step*0", "time_s=step*inf",
        "time_s=step*2 ", "time_s=nothing", "speed_m_s=I", "current_A=I", "time_h=step"}) {
    EXPECT_NE(refusal(text, renamed({rename})), "") << rename;
  }
  EXPECT_THAT(refusal(text, renamed({"time_s=nothing"})),
              AllOf(HasSubstr("--column time_s=nothing"), HasSubstr("step, I, current_A")));
}

TEST(TraceRename, OneColumnCannotBeTwoThings) {
  EXPECT_THAT(refusal("step\n0\n1\n", renamed({"time_s=step", "current_A=step"})),
              HasSubstr("--column current_A=step"));
}

struct BadRow {
  const char* row;
  const char* said;
};

TEST(TraceRows, BadOnesAreRefusedWithLineColumnAndName) {
  const BadRow cases[] = {
      {"0.75,0.2", "line 4, column 2 (current_A): the row has 2 columns, the header 3"},
      {"0.75,0.2,4,5", "line 4, column 3 (voltage_V): the row has 4 columns, the header 3"},
      {"0.75,0,2,4", "line 4, column 3 (voltage_V): the row has 4 columns, the header 3"},
      {"0.75,text,4", "line 4, column 2 (current_A): 'text' is not a finite number"},
      {"0.75,0.2,", "line 4, column 3 (voltage_V): the field is empty"},
      {",0.2,4", "line 4, column 1 (time_s): the field is empty"},
      {"0.75,nan,4", "line 4, column 2 (current_A): 'nan' is not a finite number"},
      {"0.75,0.2,-inf", "line 4, column 3 (voltage_V): '-inf' is not a finite number"},
      {"0.75,0.2,1e999", "line 4, column 3 (voltage_V): '1e999' is not a finite number"},
      {"0.75,0x10,4", "line 4, column 2 (current_A): '0x10' is not a finite number"},
      {"0.75,+0.2,4", "line 4, column 2 (current_A): '+0.2' begins with a space or a plus sign"},
      {"0.75, 0.2,4", "line 4, column 2 (current_A): ' 0.2' begins with a space or a plus sign"},
      {"0.75,0.2A,4", "line 4, column 2 (current_A): '0.2A' is not a finite number"},
      {"0.75,0.2,4;", "line 4, column 3 (voltage_V): '4;' is not a finite number"},
      {"0.75,1000.1,4",
       "line 4, column 2 (current_A): '1000.1' is out of range, -1000 to 1000 A; if it is in mA: "
       "--column current=2:mA"},
      {"0.5,0.2,4", "line 4, column 1 (time_s): time 0.5 s does not come after 0.5 s"},
      {"0.25,0.2,4", "line 4, column 1 (time_s): time 0.25 s does not come after 0.5 s"},
      {"\"0.75\",0.2,4", "line 4, column 1 (time_s): '\"0.75\"' is not a finite number"},
  };
  const std::string before = "time_s,current_A,voltage_V\n0,0.1,2\n0.5,0.2,4\n";
  for (const BadRow& bad : cases) {
    const std::string text = before + bad.row + "\n1,0.3,6\n";
    EXPECT_EQ(refusal(text), bad.said);
    const TraceContents t = read_trace(text, lenient());
    EXPECT_THAT(t.complaints, ElementsAre(bad.said));
    EXPECT_THAT(t.texts, ElementsAre("0,0.1,2", "0.5,0.2,4", "1,0.3,6"));
  }
}

TEST(TraceRows, RangesAreGivenInTheColumnsUnit) {
  EXPECT_EQ(refusal("temperature_degC\n-300\n"),
            "line 2, column 1 (temperature_degC): '-300' is out of range, -223.1 to 1727 degC");
}

TEST(TraceRows, PerCentInAColumnOfPlainNumbersAreRecognised) {
  EXPECT_EQ(refusal("strain_ref\n4.4\n"),
            "line 2, column 1 (strain_ref): '4.4' is out of range, -1 to 1; per cent are "
            "strain_ref_percent");
}

TEST(TraceRows, EmptyLinesAreNotRows) {
  const TraceContents t = read_trace("time_s\n\n0\n\r\n\n1\n\n");
  EXPECT_EQ(t.rows.size(), 2U);
  EXPECT_EQ(refusal("time_s\n\n0\n\nx\n"), "line 5, column 1 (time_s): 'x' is not a finite number");
}

TEST(TraceRows, ACutOffLastLineIsNoRow) {
  for (const hal::TraceOptions& options : {hal::TraceOptions{}, lenient()}) {
    const TraceContents t = read_trace("time_s,note,x\n0,a,1\n1,b", options);
    EXPECT_THAT(t.texts, ElementsAre("0,a,1"));
    EXPECT_EQ(t.skipped, 1U);
    EXPECT_THAT(t.complaints, ElementsAre("line 3, column 2 (note): the row has 2 columns, the "
                                          "header 3; the last line has no end, so the file was "
                                          "cut off there"));
  }
  EXPECT_EQ(read_trace("time_s\n0\n1").rows.size(), 2U) << "most programs write no last line end";
}

TEST(TraceRows, LongTextIsShortenedInMessages) {
  const std::string said = refusal("time_s\n" + std::string(500, 'x') + "\n");
  EXPECT_THAT(said, HasSubstr("'" + std::string(40, 'x') + "'"));
}

TEST(TraceRows, LenientCountsAllAndExplainsTheFirst) {
  std::string text = "time_s,current_A\n";
  for (int i = 0; i < 1000; ++i) {
    text += std::to_string(i) + (i % 3 == 0 ? ",bad\n" : ",1\n");
  }
  const TraceContents t = read_trace(text, lenient());
  EXPECT_EQ(t.skipped, 334U);
  EXPECT_EQ(t.rows.size(), 666U);
  ASSERT_EQ(t.complaints.size(), 10U);
  EXPECT_EQ(t.complaints[9], "line 29, column 2 (current_A): 'bad' is not a finite number");
}

TEST(TraceRows, ASkippedRowDoesNotMoveTime) {
  const TraceContents t = read_trace("time_s\n0\n5x\n0.5\n1e9\n", lenient());
  ASSERT_EQ(t.rows.size(), 3U);
  EXPECT_EQ(t.at(1, hal::Column::time), 0.5);
}

TEST(TraceRows, PeriodStandsInForTime) {
  hal::TraceOptions options = lenient();
  EXPECT_TRUE(std::isnan(read_trace("current_A\n1\n", options).at(0, hal::Column::time)));
  options.period_s = 0.25;
  const TraceContents t = read_trace("current_A\n1\n2\n3\n", options);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(t.at(i, hal::Column::time), 0.25 * static_cast<double>(i));
  }
  EXPECT_EQ(read_trace("time_s\n7\n", options).at(0, hal::Column::time), 7) << "a column is better";
}

TEST(TraceRows, PeriodAlsoPassesInRowsThatAreSkipped) {
  hal::TraceOptions options = lenient();
  options.period_s = 0.25;
  const TraceContents t = read_trace("current_A\n1\nbad\n3\n", options);
  ASSERT_EQ(t.rows.size(), 2U);
  EXPECT_EQ(t.at(1, hal::Column::time), 0.5);
}

}  // namespace
}  // namespace smaservo::test::trace_test
