// Rows as JSON objects; nlohmann's parser is the oracle.

#include "hal/recording/mcap/row_object.hpp"

#include <algorithm>
#include <array>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <vector>

namespace smaservo::test {
namespace {

using hal::mcap::Member;
using hal::mcap::RowObject;
using Members = std::vector<std::pair<std::string, std::string>>;

/// The members; nothing where the text is refused.
std::optional<Members> members(std::string_view json) {
  Members all;
  RowObject object(json);
  for (Member member; object.next(member);) {
    all.emplace_back(member.name, member.value);
  }
  return object.problem().empty() ? std::optional(all) : std::nullopt;
}

/// Whether nlohmann takes it as an object of plain values.
bool is_row(const std::string& json) {
  const auto parsed = nlohmann::ordered_json::parse(json, nullptr, false);
  return parsed.is_object() &&
         std::ranges::none_of(parsed, [](const auto& value) { return value.is_structured(); });
}

TEST(RowObject, GivesTheTextsOfNumbersAndWhatStringsSay) {
  EXPECT_EQ(members(R"( { "a" : -0 , "b":1.50e+03,"c":"x\"\u00e9\ud83d\ude00\n","d":null,)"
                    R"("e":true,"f":false,"g":"","\u0041":12345678901234567890})"),
            (Members{{"a", "-0"},
                     {"b", "1.50e+03"},
                     {"c", "x\"é😀\n"},
                     {"d", ""},
                     {"e", "1"},
                     {"f", "0"},
                     {"g", ""},
                     {"A", "12345678901234567890"}}));
  EXPECT_EQ(members("{}"), Members{});
}

TEST(RowObject, RefusesWhatIsNoRow) {
  for (const char* json : {"",
                           "[]",
                           "1",
                           "{",
                           "{}x",
                           "{\"a\"}",
                           "{\"a\":}",
                           "{\"a\":1,}",
                           "{\"a\":1 \"b\":2}",
                           "{a:1}",
                           "{\"a\":01}",
                           "{\"a\":+1}",
                           "{\"a\":.5}",
                           "{\"a\":1.}",
                           "{\"a\":1e}",
                           "{\"a\":-}",
                           "{\"a\":nan}",
                           "{\"a\":nul}",
                           "{\"a\":[]}",
                           "{\"a\":{}}",
                           "{\"a\":\"x}",
                           "{\"a\":\"\t\"}",
                           "{\"a\":\"\\x\"}",
                           "{\"a\":\"\\u12\"}",
                           "{\"a\":\"\\ud800\"}",
                           "{\"a\":\"\\udc00\"}",
                           "{\"a\":\"\\ud800\\u0041\"}",
                           "{\"a\":\"\\u-123\"}",
                           "{\"a\":\"\xff\"}",
                           "{\"a\":\"\xc0\x80\"}",
                           "{\"a\":\"\xed\xa0\x80\"}",
                           "{\"a\":\"\\"}) {
    EXPECT_EQ(members(json), std::nullopt) << json;
    EXPECT_FALSE(is_row(json)) << json;
  }
}

TEST(RowObject, AgreesWithNlohmannOnDamagedObjects) {
  const std::string good = R"({"time_s":0.25,"state":"a\u00e9\\","n":-1.5E-7,"z":null,"t":true})";
  constexpr std::string_view signs = "\"\\{}:,.-+eEu019 ntfa\x80\xc3";
  std::mt19937_64 random(1);
  int taken = 0;
  for (int i = 0; i < 40'000; ++i) {
    std::string json = good;
    for (std::size_t edits = 1 + random() % 3; edits > 0; --edits) {
      const std::size_t at = random() % json.size();
      switch (random() % 3) {
        case 0:
          json[at] = signs[random() % signs.size()];
          break;
        case 1:
          json.insert(at, 1, signs[random() % signs.size()]);
          break;
        default:
          json.erase(at, 1);
      }
    }
    const auto ours = members(json);
    ASSERT_EQ(ours.has_value(), is_row(json)) << json;
    taken += ours.has_value() ? 1 : 0;
  }
  EXPECT_GT(taken, 2'000);
  EXPECT_LT(taken, 30'000);
}

TEST(JsonText, IsWhatNlohmannReads) {
  std::mt19937_64 random(2);
  const std::array<std::string_view, 8> parts{"a", "\"", "\\", "\x01", "é", "😀", "\x7f", "\r"};
  for (int i = 0; i < 1000; ++i) {
    std::string text;
    for (std::size_t n = random() % 10; n > 0; --n) {
      text += parts.at(random() % parts.size());
    }
    std::string json;
    ASSERT_TRUE(hal::mcap::put_json_text(json, text));
    ASSERT_EQ(nlohmann::json::parse(json).get<std::string>(), text);
  }
  std::string refused;
  EXPECT_FALSE(hal::mcap::put_json_text(refused, "\xff"));
  EXPECT_FALSE(hal::mcap::put_json_text(refused, "a\xc3"));
}

}  // namespace
}  // namespace smaservo::test
