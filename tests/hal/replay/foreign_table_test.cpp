// Spreadsheets and MATLAB files: the same rows as those of a CSV file, whatever wrote them. The
// files are in tables/, with the script that has made them.

#include "hal/recording/foreign_table.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <random>
#include <unistd.h>

#include "model/files/error.hpp"
#include "tests/hal/replay/traces.hpp"
#include "tests/places.hpp"

namespace smaservo::test::foreign_table_test {
namespace {

using ::testing::AnyOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::StartsWith;

std::string table(const std::string& name) {
  return source_folder() + "/tests/hal/replay/tables/" + name;
}

struct Said {
  TraceContents contents;
  std::string read_as;
};

Said read(const std::string& path, const hal::TraceOptions& options = {}) {
  hal::TraceReader reader(path, options);
  Said said{read_all(reader), {}};
  said.read_as = reader.read_as();
  return said;
}

/// What refuses the file.
std::string refusal_of(const std::string& path, const hal::TraceOptions& options = {}) {
  try {
    read(path, options);
  } catch (const hal::TraceError& error) {
    return error.what();
  }
  return "";
}

TEST(ForeignTable, HasTheRowsOfTheCsv) {
  const Said expected = read(table("run.csv"));
  ASSERT_EQ(expected.contents.rows.size(), 30U);
  for (const std::string name : {"run.xlsx", "by_hand.xlsx", "run.ods", "run_5.mat", "struct_5.mat",
                                 "matrix_5.mat", "run_73.mat"}) {
    SCOPED_TRACE(name);
    const Said said = read(table(name));
    EXPECT_EQ(said.contents.skipped, 0U);
    ASSERT_EQ(said.contents.rows.size(), expected.contents.rows.size());
    for (std::size_t row = 0; row < said.contents.rows.size(); ++row) {
      for (const hal::Column column :
           {hal::Column::time, hal::Column::current, hal::Column::voltage, hal::Column::load}) {
        ASSERT_EQ(said.contents.at(row, column), expected.contents.at(row, column)) << row;
      }
    }
  }
}

TEST(ForeignTable, SaysWhatItTook) {
  EXPECT_EQ(
      read(table("run.xlsx")).read_as,
      "sheet 'Run 3, \"warm\"\\x7F', one of 3, of an Excel file, names in row 3; time = column "
      "1 'Time [s]' in s; current = column 2 'I [mA]' in mA; voltage = column 3 'Voltage (V)' "
      "in V; load = column 4 'Load [N]' in N");
  EXPECT_THAT(read(table("run.ods")).read_as,
              StartsWith("sheet 'Lauf 1', one of 2, of an OpenDocument file, names in row 1; "));
  EXPECT_EQ(read(table("run_5.mat")).read_as, "MATLAB 5 file");
  EXPECT_EQ(read(table("run_73.mat")).read_as, "MATLAB 7.3 file");
  hal::TraceOptions options;
  options.renames = {"time=1:s", "current=2:mA", "voltage=3:V"};
  const Said bare = read(table("bare_5.mat"), options);
  EXPECT_THAT(bare.read_as, StartsWith("MATLAB 5 file, no names"));
  EXPECT_EQ(bare.contents.rows.size(), 30U);
}

TEST(ForeignTable, TextsAreKept) {
  const auto texts = read(table("run.xlsx")).contents.texts;
  EXPECT_THAT(texts.at(4), HasSubstr("a note; with a comma"));
  EXPECT_THAT(read(table("run.ods")).contents.texts.at(2), HasSubstr("warm"));
}

TEST(ForeignTable, ReadsTimesOfCells) {
  const TraceContents rows = read(table("clock.xlsx")).contents;
  ASSERT_EQ(rows.rows.size(), 4U);
  EXPECT_EQ(rows.at(0, hal::Column::time), 1795869000);
  EXPECT_EQ(rows.at(1, hal::Column::time), 1795869000.25);
  EXPECT_THAT(rows.texts.at(3), HasSubstr("45000.75")) << "a clock is seconds since midnight";
}

// A missing number is an empty field, as everywhere; integers, flags and single precision are
// exact.
TEST(ForeignTable, TakesAnyClassOfNumbers) {
  hal::TraceOptions options;
  options.lenient = true;
  const TraceContents rows = read(table("kinds_5.mat"), options).contents;
  ASSERT_EQ(rows.rows.size(), 3U);
  EXPECT_EQ(rows.at(1, hal::Column::current), static_cast<double>(0.2F));
  EXPECT_EQ(rows.at(2, hal::Column::voltage), 4);
  ASSERT_EQ(rows.complaints.size(), 1U);
  EXPECT_THAT(rows.complaints[0], HasSubstr("row 3, column 2 (current_A): the field is empty"));
}

TEST(ForeignTable, MessagesNameTheRowOfTheSheet) {
  hal::TraceOptions options;
  options.renames = {"current=5:A"};
  EXPECT_THAT(refusal_of(table("run.xlsx"), options),
              HasSubstr("run.xlsx: row 4, column 5 (note; by \"me\" and us)"));
}

TEST(ForeignTable, RefusesWhatIsNoTable) {
  const std::pair<std::string_view, std::string_view> files[] = {
      {"no_sheet.zip", "is a zip archive and no spreadsheet; unpack it first"},
      {"encrypted.ods", "is encrypted; save it without a password"},
      {"no_rows.xlsx", "none of its 1 sheets has a row of two numbers or more"},
      {"entities.xlsx", "declares a document type"},
      {"repeated.ods", "a sheet has more than"},
      {"object_5.mat", "holds an object of MATLAB"},
      {"object_73.mat",
       "holds 'T', an object of MATLAB, as a table, timetable or timeseries is, which only MATLAB "
       "reads; there, writetable(T, \"run.csv\")"},
      {"nothing_5.mat",
       "there are: z (complex double 1 x 2), cube (double 2 x 2 x 2), name (char 1 x 1), t (double "
       "1 x 1), none (double 0 x 0)"},
  };
  for (const auto& [name, reason] : files) {
    EXPECT_THAT(refusal_of(table(std::string(name))), HasSubstr(reason)) << name;
  }
  EXPECT_THAT(refusal("MATLAB 5.0 MAT-file, and no more"), HasSubstr("cut off"));
  EXPECT_THAT(refusal("PK\x03\x04 and more"), HasSubstr("zip archive is damaged"));
  EXPECT_THAT(refusal("\x89HDF\r\n\x1A\n"), HasSubstr("HDF5 file that MATLAB has not written"));
  EXPECT_THAT(refusal("\xD0\xCF\x11\xE0\xA1\xB1\x1A\xE1"), HasSubstr("save the sheet as .xlsx"));
}

// The content decides.
TEST(ForeignTable, ANameTellsNothing) {
  const TemporaryFolder folder;
  const std::string text = file_text(table("run.csv"));
  EXPECT_EQ(read(folder.write("run.mat", text)).contents.rows.size(), 30U);
  EXPECT_EQ(read(folder.write("run.csv", file_text(table("run_5.mat")))).contents.rows.size(), 30U);
}

TEST(ForeignTable, IsReadFromAFileOnly) {
  const std::string content = file_text(table("run_5.mat"));
  std::array<int, 2> ends{};
  ASSERT_EQ(pipe(ends.data()), 0);
  ASSERT_EQ(write(ends[1], content.data(), content.size()), static_cast<ssize_t>(content.size()));
  close(ends[1]);
  EXPECT_THAT(refusal_of(fmt::format("/proc/self/fd/{}", ends[0])),
              HasSubstr("cannot be read from a pipe; save it as a file first"));
  close(ends[0]);
  const TemporaryFolder folder;
  const std::string path = folder.write("run.mat", content);
  // NOLINTNEXTLINE(bugprone-command-processor): the path is the test's own
  ASSERT_EQ(std::system(fmt::format("gzip -q '{}'", path).c_str()), 0);
  EXPECT_THAT(refusal_of(path + ".gz"), HasSubstr("compressed once more; unpack it first"));
}

/// What is said where the program that reads the file ends in this way; a script stands for it.
std::string said_with(const std::string& script) {
  const TemporaryFolder folder;
  const std::string program = folder / "program";
  if (!script.empty()) {
    folder.write("program", "#!/bin/sh\n" + script + "\n");
    std::filesystem::permissions(program, std::filesystem::perms::owner_all);
  }
  const int file = open("/dev/null", O_RDONLY | O_CLOEXEC);
  std::string said;
  try {
    hal::ForeignTable foreign(file, program);
    std::array<char, 100> part{};
    while (foreign.read(part.data(), part.size()) > 0) {
    }
  } catch (const files::UserError& error) {
    said = error.what();
  }
  close(file);
  return said;
}

TEST(ForeignTable, SaysHowTheOtherProgramEnded) {
  EXPECT_THAT(said_with(""), HasSubstr("smaservo-table, which cannot be started"));
  EXPECT_EQ(said_with("echo a table"), "");
  EXPECT_EQ(said_with("echo a table; echo one >&2; echo two >&2; exit 1"), "one");
  EXPECT_EQ(said_with("exit 5"), "the program that reads it ended with 5; save it as CSV");
  EXPECT_EQ(said_with("exit 0"), "smaservo-table wrote nothing");
  EXPECT_THAT(said_with("echo a table; kill -SEGV $$"),
              HasSubstr("crashed, so the file is probably damaged"));
  EXPECT_THAT(said_with("kill -XCPU $$"), HasSubstr("more than a minute"));
  EXPECT_THAT(said_with("echo 'libmatio.so.9: not found' >&2; exit 127"),
              AllOf(HasSubstr("libmatio.so.9"), HasSubstr("install Debian's packages libexpat1 ")));
}

TEST(ForeignTable, EndsTheOtherProgramWhenNobodyReadsOn) {
  const TemporaryFolder folder;
  const std::string program =
      folder.write("program", "#!/bin/sh\necho a table\necho $$\nexec sleep 1000\n");
  std::filesystem::permissions(program, std::filesystem::perms::owner_all);
  std::string number;
  {
    const int file = open("/dev/null", O_RDONLY | O_CLOEXEC);
    hal::ForeignTable foreign(file, program);
    close(file);
    std::array<char, 100> part{};
    number.assign(part.data(), foreign.read(part.data(), part.size()));
  }
  EXPECT_EQ(kill(std::stoi(number), 0), -1) << number;
}

/// Reads a file that may be damaged: its rows, or a message, which says more than that a program
/// failed.
void read_damaged(const TemporaryFolder& folder, std::string_view content) {
  const std::string said = refusal_of(folder.write("damaged", content));
  EXPECT_THAT(said, AnyOf(IsEmpty(), StartsWith((folder / "damaged") + ": "))) << said;
}

// Some milliseconds each, most of them for the start of the other program. Checksums find nearly
// all damage of an archive, so those have fewer tries.
TEST(ForeignTable, CutOffOrDamagedIsReadOrRefused) {
  const TemporaryFolder folder;
  std::mt19937 random(43);
#ifdef SMASERVO_SANITIZED
  constexpr int fewer = 10;
#else
  constexpr int fewer = 1;
#endif
  constexpr std::pair<const char*, int> files[] = {{"by_hand.xlsx", 20},
                                                   {"run.ods", 20},
                                                   {"run_5.mat", 60},
                                                   {"struct_5.mat", 150},
                                                   {"run_73.mat", 150}};
  for (const auto& [name, tries] : files) {
    SCOPED_TRACE(name);
    const std::string whole = file_text(table(name));
    for (std::size_t size = 0; size < whole.size(); size += std::size_t{37} * fewer) {
      const std::string path = folder.write("cut", std::string_view(whole).substr(0, size));
      const std::string said = refusal_of(path);
      EXPECT_NE(said, "") << size;
      if (size >= 128) {
        EXPECT_THAT(said, AnyOf(HasSubstr("cut off"), HasSubstr("damaged"))) << size;
      }
    }
    for (int i = 0; i < tries / fewer; ++i) {
      std::string damaged = whole;
      char& byte = damaged[random() % damaged.size()];
      byte = static_cast<char>(static_cast<unsigned char>(byte) ^ (1U << random() % 8));
      read_damaged(folder, damaged);
    }
  }
}

}  // namespace
}  // namespace smaservo::test::foreign_table_test
