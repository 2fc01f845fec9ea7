// `host-sim describe` and `explain` as their user meets them, and the pages that are made by it.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "firmware/parameters/parameters.hpp"
#include "firmware/safety/faults/table.hpp"
#include "firmware/text/canopen/parameter_reference.hpp"
#include "firmware/text/settings_file.hpp"
#include "model/files/wire/wire_header.hpp"
#include "tests/host-sim/program.hpp"
#include "tests/places.hpp"

namespace smaservo::test {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

TEST(Describe, TheCommittedParameterReferenceIsUpToDate) {
  EXPECT_TRUE(file_text(test::source_folder() + "/firmware/reference/PARAMETERS.md") ==
              text::parameter_reference())
      << "firmware/reference/PARAMETERS.md is stale; make it anew from the top folder:\n"
         "  build/release/host-sim/host-sim describe parameters > firmware/reference/PARAMETERS.md";
}

TEST(Describe, TheReferenceHasEveryParameter) {
  const std::string page = text::parameter_reference();
  for (const Parameter<float>& row : parameters<float>) {
    EXPECT_THAT(page, HasSubstr("`" + std::string(row.path.text()) + "`"));
  }
}

TEST(Describe, PrintsTheReference) {
  Program program;
  const Finished f = program.run({"describe", "parameters"});
  EXPECT_EQ(f.status, 0);
  EXPECT_EQ(f.out, text::parameter_reference());
}

TEST(Describe, PrintsSettingsThatCanBeRead) {
  Program program;
  const Finished f = program.run({"describe", "settings", "--wire", "flexinol-ht-0.10mm"});
  EXPECT_EQ(f.status, 0);
  const std::string file = program.folder().write("device.toml", f.out);
  EXPECT_EQ(text::load_settings_file(file).wire.geometry.diameter_m, static_cast<double>(1e-4F));
}

TEST(Describe, PrintsAWireThatCanBeRead) {
  Program program;
  const Finished f = program.run({"describe", "wire", "--wire", "flexinol-ht-0.10mm"});
  EXPECT_EQ(f.status, 0);
  EXPECT_EQ(f.out, files::to_toml(files::load_wire("flexinol-ht-0.10mm")));
}

TEST(Describe, OnlyAWireIsAHeader) {
  Program program;
  Finished f = program.run({"describe", "wire", "--as", "header"});
  EXPECT_EQ(f.status, 0);
  EXPECT_EQ(f.out, files::to_header(files::load_wire(std::string(files::default_wire))));
  f = program.run({"describe", "faults", "--as", "header"});
  EXPECT_EQ(f.status, 1);
  EXPECT_THAT(f.err, HasSubstr("describe faults --as header: --as is for the topic wire alone"));
  f = program.run({"describe", "wire", "--as", "json"});
  EXPECT_NE(f.status, 0);
  EXPECT_THAT(f.err, HasSubstr("--as"));
}

TEST(Describe, UnknownTopicsAndWiresEndWith1) {
  Program program;
  Finished f = program.run({"describe", "weather"});
  EXPECT_EQ(f.status, 1);
  EXPECT_THAT(f.err, HasSubstr("describe weather: no such topic; the topics are dbc, eds, "));
  f = program.run({"describe", "settings", "--wire", "copper"});
  EXPECT_EQ(f.status, 1);
  EXPECT_THAT(f.err, HasSubstr("copper: no such wire"));
}

TEST(Explain, SaysWhatAFaultMeans) {
  Program program;
  const Finished f = program.run({"explain", "over_current"});
  EXPECT_EQ(f.status, 0);
  EXPECT_THAT(f.out, StartsWith("over_current (2310h)\n"));
  EXPECT_THAT(f.out, HasSubstr("trips.current_A"));
  EXPECT_EQ(program.run({"explain", "0x2310"}).out, f.out);
  const Finished all = program.run({"explain"});
  for (const FaultRow& row : fault_rows) {
    EXPECT_THAT(all.out, HasSubstr(std::string(row.name)));
  }
}

TEST(Explain, RefusesWhatIsNoFault) {
  Program program;
  const Finished f = program.run({"explain", "overcurrent"});
  EXPECT_EQ(f.status, 1);
  EXPECT_EQ(f.out, "");
  EXPECT_THAT(f.err, StartsWith("host-sim: overcurrent: no such fault; did you mean over_current"));
}

}  // namespace
}  // namespace smaservo::test
