#include "firmware/text/fault_reference.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "firmware/safety/faults/table.hpp"
#include "tests/hal/replay/temporary_folder.hpp"
#include "tests/places.hpp"

namespace smaservo::test {
namespace {

using ::testing::Contains;
using ::testing::IsEmpty;

/// Anew: build/release/host-sim/host-sim describe faults > firmware/reference/FAULTS.md
TEST(FaultReference, ThePageIsUpToDate) {
  EXPECT_EQ(file_text(test::source_folder() + "/firmware/reference/FAULTS.md"),
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

}  // namespace
}  // namespace smaservo::test
