#include "firmware/text/reference/fault_reference.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "firmware/safety/faults/table.hpp"
#include "tests/host-sim/program.hpp"

namespace smaservo::test {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::StartsWith;

/// Anew: build/release/host-sim/host-sim describe faults > firmware/reference/FAULTS.md
TEST(FaultReference, ThePageIsUpToDate) {
  EXPECT_EQ(file_text(SMASERVO_SOURCE_DIR "/firmware/reference/FAULTS.md"),
            text::fault_reference());
}

TEST(FaultReference, FindsEveryFaultByNameAndCode) {
  for (const FaultRow& row : fault_rows) {
    EXPECT_EQ(text::find_fault(row.name), row.fault);
    char hexadecimal[8];
    std::snprintf(hexadecimal, sizeof hexadecimal, "%04Xh", unsigned{row.code});
    EXPECT_EQ(text::find_fault(hexadecimal), row.fault);
    EXPECT_EQ(text::find_fault(std::to_string(row.code)), row.fault);
  }
  for (const char* none : {"", "none", "wire", "0x", "h", "2310g", "-1", "99999999999"}) {
    EXPECT_EQ(text::find_fault(none), Fault::none) << none;
  }
}

TEST(FaultReference, KnowsWhatWasMeant) {
  EXPECT_EQ(text::similar_faults("wire_opn").front(), "wire_open");
  EXPECT_THAT(text::similar_faults("slip"), Contains("clamp_slip"));
  EXPECT_THAT(text::similar_faults("xyzzyxyzzyxyzzyxyzzy"), IsEmpty());
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
