#include "host-sim/record/sums.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "model/files/error.hpp"
#include "tests/hal/replay/temporary_folder.hpp"

namespace smaservo::record {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

// The examples of FIPS 180-4, and NIST's million letters.
TEST(Sha256, IsTheStandards) {
  const test::TemporaryFolder folder;
  const auto sum_of = [&](const std::string& text) {
    return sha256_of_file(folder.write("x", text));
  };
  EXPECT_EQ(sum_of(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(sum_of("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(sum_of(std::string(1'000'000, 'a')),
            "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
  EXPECT_THROW(sha256_of_file(folder / "none"), files::UserError);
  EXPECT_THROW(sha256_of_file(folder.path().string()), files::UserError);
}

TEST(Sums, AreReadAsTheyAreWritten) {
  const std::vector<Sum> sums{{std::string(64, 'a'), "runs/x.csv"}, {std::string(64, '0'), "a b"}};
  std::vector<std::string> faults;
  const std::vector<Sum> again = parse_sums(sums_text(sums), "S", faults);
  EXPECT_THAT(faults, IsEmpty());
  ASSERT_EQ(again.size(), 2U);
  EXPECT_EQ(again[1].path, "a b");
  EXPECT_EQ(parse_sums(std::string(64, 'A') + " *x\r\n", "S", faults)[0].hex, std::string(64, 'a'));
  EXPECT_THAT(
      parse_sums("\n" + std::string(63, 'a') + "  x\n" + std::string(64, 'g') + "  x", "S", faults),
      IsEmpty());
  EXPECT_THAT(faults, ElementsAre(HasSubstr("S:1: "), HasSubstr("S:2: "), HasSubstr("S:3: ")));
}

TEST(Sums, PathsThatLeaveTheFolderAreKnown) {
  for (const char* const path : {"x", "runs/x.csv", "..x", "x..", "a/.b"}) {
    EXPECT_TRUE(stays_inside(path)) << path;
  }
  for (const char* const path : {"", "/x", "../x", "a/../../x", "a//x", "./x", "a/..", ".."}) {
    EXPECT_FALSE(stays_inside(path)) << path;
  }
}

}  // namespace
}  // namespace smaservo::record
