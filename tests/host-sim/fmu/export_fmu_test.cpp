// `host-sim export-fmu` as its user meets it.

#include <filesystem>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/host-sim/program.hpp"

namespace smaservo::test {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::StartsWith;

TEST(ExportFmu, SaysWhatItHasWritten) {
  Program program;
  const Finished f = program.run({"export-fmu", "--wire", "smartflex-76um", "--out", "a.fmu"});
  EXPECT_EQ(f.status, 0) << f.err;
  EXPECT_THAT(f.out,
              StartsWith("a.fmu: FMI 3.0, co-simulation, smaservo_wire; 4 inputs, 8 outputs, "
                         "68 parameters; "));
  EXPECT_THAT(f.out, HasSubstr("\nlibraries for "));
  EXPECT_THAT(f.out, HasSubstr("-linux"));
  EXPECT_EQ(program.folder().names(), std::vector<std::string>{"a.fmu"});
}

TEST(ExportFmu, TakesTheWireOfAFileAndChangesOfIt) {
  Program program;
  program.folder().write("mine.toml", "based_on = \"smartflex-76um\"\n[wire]\nlength_mm = 120\n");
  EXPECT_EQ(program
                .run({"export-fmu", "--wire", "mine.toml", "--set", "wire.diameter_um=75", "--kind",
                      "wire", "--fmi", "2", "--out", "a.fmu"})
                .status,
            0);
  program.folder().write("device.toml", "wire = \"smartflex-76um\"\n[limits]\ncurrent_mA = 80\n");
  EXPECT_EQ(program
                .run({"export-fmu", "--settings", "device.toml", "--wire", "mine.toml", "--kind",
                      "servo", "--out", "b.fmu"})
                .status,
            0);
}

TEST(ExportFmu, MistakesAreNamedAndLeaveNothing) {
  Program program;
  program.folder().write("broken.toml", "[wire\n");
  program.folder().write("lacking.toml", "[wire]\nlength_mm = 100\n");
  program.folder().write("device.toml", "wire = \"smartflex-76um\"\n[limits]\ncurrent_A = 15\n");
  const std::vector<std::string> before = program.folder().names();
  const struct {
    int status;
    Program::Texts arguments;
    const char* message;
  } cases[] = {
      {1, {"--wire", "smartflex-76", "--out", "a.fmu"}, "smartflex-76"},
      {1, {"--wire", "nowhere.toml", "--out", "a.fmu"}, "nowhere.toml"},
      {1, {"--wire", "broken.toml", "--out", "a.fmu"}, "broken.toml:"},
      {1, {"--wire", "lacking.toml", "--out", "a.fmu"}, "lacking.toml: wire."},
      {1, {"--wire", "smartflex-76um", "--set", "wire.lenght_mm=1", "--out", "a.fmu"}, "lenght"},
      {1, {"--wire", "smartflex-76um", "--set", "wire.length_mm=-1", "--out", "a.fmu"}, "length"},
      {1, {"--out", "a.fmu"}, "--wire: name a preset or a file"},
      {1, {"--wire", "smartflex-76um", "--out", "a.zip"}, "--out a.zip: must end in .fmu"},
      {1, {"--wire", "smartflex-76um", "--out", "no/a.fmu"}, "no/a.fmu: cannot be written"},
      {1, {"--wire", "smartflex-76um", "--out", "/proc/a.fmu"}, "/proc/a.fmu: cannot be written"},
      {1,
       {"--wire", "smartflex-76um", "--settings", "device.toml", "--out", "a.fmu"},
       "--settings: is of --kind servo"},
      {1,
       {"--settings", "device.toml", "--kind", "servo", "--out", "a.fmu"},
       "device.toml:3: limits.current_A = 15"},
      {1, {"--settings", "none.toml", "--kind", "servo", "--out", "a.fmu"}, "none.toml"},
      {1,
       {"--wire", "smartflex-76um", "--kind", "servo", "--set", "limits.nothing=1", "--out",
        "a.fmu"},
       "limits.nothing"},
      {1, {"--wire", "smartflex-76um", "--load-N", "-1", "--out", "a.fmu"}, "--load-N"},
      {1, {"--wire", "smartflex-76um", "--load-N", "nan", "--out", "a.fmu"}, "--load-N"},
      {2, {"--wire", "smartflex-76um", "--fmi", "4", "--out", "a.fmu"}, "--fmi"},
      {2, {"--wire", "smartflex-76um", "--kind", "tree", "--out", "a.fmu"}, "--kind"},
      {2, {"--wire", "smartflex-76um"}, "--out is required"},
  };
  for (const auto& one : cases) {
    Program::Texts arguments = one.arguments;
    arguments.insert(arguments.begin(), "export-fmu");
    const Finished f = program.run(arguments);
    EXPECT_EQ(f.status, one.status) << one.message << '\n' << f.err;
    EXPECT_THAT(f.err, HasSubstr(one.message));
    EXPECT_THAT(f.out, IsEmpty()) << one.message;
    EXPECT_EQ(program.folder().names(), before) << one.message;
  }
}

TEST(ExportFmu, AFullDiskIsAnError) {
  Program program;
  std::filesystem::create_symlink("/dev/full", program.folder() / "a.fmu");
  const Finished f = program.run({"export-fmu", "--wire", "smartflex-76um", "--out", "a.fmu"});
  EXPECT_EQ(f.status, 1);
  EXPECT_THAT(f.err, HasSubstr("a.fmu: cannot be written: No space left on device"));
}

TEST(ExportFmu, AnFmuThatIsThereStaysUntilTheNewOneIsWhole) {
  Program program;
  program.folder().write("a.fmu", "old");
  EXPECT_EQ(program.run({"export-fmu", "--wire", "no-such-wire", "--out", "a.fmu"}).status, 1);
  EXPECT_EQ(file_text(program.folder() / "a.fmu"), "old");
  EXPECT_EQ(program.run({"export-fmu", "--wire", "smartflex-76um", "--out", "a.fmu"}).status, 0);
  EXPECT_THAT(file_text(program.folder() / "a.fmu"), StartsWith("PK\x03\x04"));
}

}  // namespace
}  // namespace smaservo::test
