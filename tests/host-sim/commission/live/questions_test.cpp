#include "host-sim/commission/live/questions.hpp"

#include <gmock/gmock.h>

#include "tests/host-sim/commission/live/scripted_person.hpp"

namespace smaservo::commission {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

struct Questions : testing::Test {
  /// Asks at 100 s of the clock for at most 20 s, and looks each second. The time that it took.
  std::int64_t ask(double time_s = 1) {
    constexpr std::int64_t begin_us = 100'000'000;
    Question question(person, readings, begin_us + 20'000'000);
    for (std::int64_t now_us = begin_us;; now_us += 1'000'000) {
      if (question.look(now_us, time_s)) {
        return (now_us - begin_us) / 1'000'000;
      }
    }
  }

  ScriptedPerson person;
  Readings readings{0.2e-3, 0.1};
};

TEST(ReadingMm, ReadsWhatPeopleType) {
  EXPECT_EQ(reading_mm("3.4"), 3.4);
  EXPECT_EQ(reading_mm(" 3,4 mm\r"), 3.4);
  EXPECT_EQ(reading_mm("-0.5mm"), -0.5);
  EXPECT_EQ(reading_mm("+12"), 12);
  for (const char* const wrong : {"", "mm", "3.4.5", "3 4", "three", "nan", "inf", "1e3", "3.4 cm",
                                  "99999", "--1", "+-1", "0x10"}) {
    EXPECT_EQ(reading_mm(wrong), std::nullopt) << wrong;
  }
}

TEST_F(Questions, ColdReadingIsTheZero) {
  person.answers = {"12.0", "15.5"};
  EXPECT_EQ(ask(0), 0);
  EXPECT_EQ(ask(30), 0);
  ASSERT_THAT(readings.anchors(), SizeIs(2));
  EXPECT_EQ(readings.anchors()[0].displacement_m, 0);
  EXPECT_EQ(readings.anchors()[1].time_s, 30);
  EXPECT_NEAR(readings.anchors()[1].displacement_m, 3.5e-3, 1e-12);
  EXPECT_EQ(readings.anchors()[1].sd_m, 0.2e-3);
}

// A ruler beside the wire may count either way.
TEST_F(Questions, AScaleMayFallWhereTheWireContracts) {
  person.answers = {"12.0", "8.5", "9.5"};
  for (int i = 0; i < 3; ++i) {
    ask();
  }
  ASSERT_THAT(readings.anchors(), SizeIs(3));
  EXPECT_NEAR(readings.anchors()[1].displacement_m, 3.5e-3, 1e-12);
  EXPECT_NEAR(readings.anchors()[2].displacement_m, 2.5e-3, 1e-12);
}

TEST_F(Questions, WrongTypingIsExplainedAndAskedAgain) {
  person.answers = {"12.0"};
  ask();
  person.answers = {"x\x1B[2J", "45", "15"};
  EXPECT_EQ(ask(), 2);
  ASSERT_THAT(person.said, SizeIs(2));
  EXPECT_THAT(person.said[0], HasSubstr("'x\\x1B[2J' is no length"));
  EXPECT_THAT(person.said[1], HasSubstr("moves by at most 10 mm"));
  EXPECT_THAT(person.asked, SizeIs(4));
  ASSERT_THAT(readings.anchors(), SizeIs(2));
  person.answers = {"9", ""};
  ask();
  EXPECT_THAT(person.said.back(), HasSubstr("longer than when it was cold"));
  EXPECT_THAT(readings.anchors(), SizeIs(2));
}

TEST_F(Questions, EnterIsNoReading) {
  person.answers = {"\r"};
  EXPECT_EQ(ask(), 0);
  EXPECT_THAT(readings.anchors(), IsEmpty());
  EXPECT_THAT(person.said, IsEmpty());
}

TEST_F(Questions, TimeEndsAQuestion) {
  person.answers = {ScriptedPerson::silence};
  EXPECT_EQ(ask(), 20);
  EXPECT_THAT(person.said, ElementsAre(HasSubstr("goes on without")));
}

TEST_F(Questions, NobodyIsNotAsked) {
  person.there = false;
  EXPECT_EQ(ask(), 0);
  EXPECT_THAT(person.asked, IsEmpty());
}

}  // namespace
}  // namespace smaservo::commission
