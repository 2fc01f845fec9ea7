#include "model/files/similar.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <random>

namespace smaservo::test {
namespace {

using ::testing::IsEmpty;

const std::vector<std::string> commands{"replay",   "replay-device", "identify", "inspect",
                                        "simulate", "convert",       "tune",     "can"};

TEST(Similar, FindsWhatWasMeant) {
  EXPECT_EQ(files::similar("repaly", commands).front(), "replay");
  EXPECT_EQ(files::similar("IDENTFY", commands).front(), "identify") << "in any case";
  EXPECT_EQ(files::similar("ulate", commands).front(), "simulate") << "a part";
  EXPECT_EQ(files::did_you_mean("simulat", commands), " (did you mean simulate?)");
  EXPECT_THAT(files::similar("xyzzy", commands), IsEmpty());
  EXPECT_THAT(files::similar("", commands), IsEmpty());
  EXPECT_EQ(files::did_you_mean("xyzzy", commands), "");
}

// One letter that was left out, doubled, swapped with its neighbour or mistaken.
TEST(Similar, FindsEachNameWithOneMistake) {
  std::mt19937 random(5);
  for (int i = 0; i < 2000; ++i) {
    const std::string& name = commands[random() % commands.size()];
    std::string typed = name;
    const std::size_t at = random() % (name.size() - 1);
    switch (random() % 4) {
      case 0:
        typed.erase(at, 1);
        break;
      case 1:
        typed.insert(at, 1, typed[at]);
        break;
      case 2:
        std::swap(typed[at], typed[at + 1]);
        break;
      default:
        typed[at] = 'q';
    }
    const std::vector<std::string> found = files::similar(typed, commands);
    ASSERT_FALSE(found.empty()) << typed;
    if (name.size() > 4) {
      ASSERT_EQ(found.front(), name) << typed;
    }
  }
}

}  // namespace
}  // namespace smaservo::test
