// CSV text becomes an MCAP file and the same text again, whatever it holds and in whatever pieces
// it comes; a file that was cut off gives the rows before; a damaged one a message with an offset.

#include <charconv>
#include <cmath>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <random>

#include "tests/hal/recording/mcap/files.hpp"

namespace smaservo::test {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

std::string shortest(double value) {
  std::array<char, 32> text{};
  return {text.data(), std::to_chars(text.data(), text.data() + text.size(), value).ptr};
}

/// Rows of numbers of all sizes, texts and gaps; a column for each kind, and one that changes it.
std::string random_csv(std::mt19937_64& random, std::size_t rows) {
  constexpr std::array<std::string_view, 6> texts{"", "ready", "a b", "\"quoted\"", "-", "é\\"};
  std::string csv = "time_s,value,sparse,state,none,mixed\n";
  for (std::size_t i = 0; i < rows; ++i) {
    const auto bits = random();
    double value = 0;
    std::memcpy(&value, &bits, sizeof(value));
    csv += fmt::format("{},{},{},{},,{}\n", shortest(1e-3 * static_cast<double>(i)),
                       std::isfinite(value) ? shortest(value) : "",
                       random() % 3 == 0 ? shortest(-0.0) : "", texts.at(random() % texts.size()),
                       random() % 2 == 0 ? "12.50" : "x");
  }
  return csv;
}

TEST(McapRows, ComeBackToTheSameText) {
  std::mt19937_64 random(1);
  for (const std::size_t rows : {0U, 1U, 2U, 700U, 20'000U}) {
    const std::string csv = random_csv(random, rows);
    for (const bool compressed : {true, false}) {
      const std::string bytes = to_mcap(csv, compressed);
      EXPECT_EQ(read_mcap(bytes), (Read{csv, "", ""})) << rows;
    }
  }
}

TEST(McapRows, PiecesDoNotMatter) {
  std::mt19937_64 random(2);
  const std::string csv = random_csv(random, 3000);
  const std::string bytes = to_mcap(csv);
  mcap::RowsWriter writer({"test", "memory"}, {});
  std::string pieces;
  for (std::string_view rest = csv; !rest.empty();) {
    const std::size_t part = std::min<std::size_t>(rest.size(), 1 + random() % 200);
    writer.add(rest.substr(0, part));
    pieces += writer.take();
    rest.remove_prefix(part);
  }
  writer.finish();
  pieces += writer.take();
  EXPECT_TRUE(pieces == bytes);
  EXPECT_EQ(read_mcap(bytes, 7), (Read{csv, "", ""}));
}

TEST(McapRows, NumbersOfOtherFormsKeepTheirValue) {
  EXPECT_EQ(read_mcap(to_mcap("\xEF\xBB\xBF x , y,id\r\n.5,5.,007\r\n\r\n-.25,1e400,8\r\n")).csv,
            "x,y,id\n0.5,5,007\n-0.25,1e400,8\n");
}

TEST(McapRows, AFileThatWasCutOffHasTheRowsBefore) {
  std::mt19937_64 random(3);
  const std::string csv = random_csv(random, 90);
  mcap::RowsWriter writer({"test", "memory"},
                          {mcap::Kind::number, mcap::Kind::number, mcap::Kind::number,
                           mcap::Kind::text, mcap::Kind::text, mcap::Kind::text});
  std::string bytes;
  std::vector<std::pair<std::size_t, std::size_t>> closed{{0, 0}};  // bytes, rows
  std::size_t at = csv.find('\n') + 1;
  writer.add(csv.substr(0, at));
  for (std::size_t row = 1; row <= 90; ++row) {
    const std::size_t end = csv.find('\n', at) + 1;
    writer.add(csv.substr(at, end - at));
    at = end;
    if (row % 15 == 0) {
      writer.flush();
      bytes += writer.take();
      closed.emplace_back(bytes.size(), row);
    }
  }
  const std::size_t unfinished = bytes.size();
  writer.finish();
  bytes += writer.take();
  EXPECT_EQ(read_mcap(bytes), (Read{csv, "", ""}));
  std::size_t had_columns = 0;
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    const Read read = read_mcap(std::string_view(bytes).substr(0, size));
    if (read.csv.empty()) {
      EXPECT_NE(read.problem, "");
      EXPECT_LT(size, closed[1].first);
      continue;
    }
    ++had_columns;
    EXPECT_EQ(read.problem, "");
    EXPECT_THAT(read.cut_off, StartsWith(fmt::format("byte {}: the file ends", size)));
    EXPECT_TRUE(csv.starts_with(read.csv));
    const auto rows = static_cast<std::size_t>(std::ranges::count(read.csv, '\n')) - 1;
    const auto whole =
        std::ranges::find_if(closed, [&](const auto& chunk) { return chunk.first > size; });
    // A chunk can be read before its index is there.
    const std::size_t most = whole == closed.end() ? 90 : whole->second;
    EXPECT_GE(rows, (whole - 1)->second);
    EXPECT_LE(rows, most);
  }
  EXPECT_GT(had_columns, unfinished / 2);
}

TEST(McapRows, NoChangedByteIsTakenForGranted) {
  std::mt19937_64 random(4);
  const std::string csv = random_csv(random, 40);
  const std::string good = to_mcap(csv);
  for (std::size_t at = 0; at < good.size(); ++at) {
    std::string bytes = good;
    bytes[at] = static_cast<char>(bytes[at] ^ (1 << (at % 8)));
    const Read read = read_mcap(bytes);
    // All bytes have a checksum but that itself, the lengths behind which the file then ends, and
    // what is behind the summary's.
    EXPECT_TRUE(!read.problem.empty() || !read.cut_off.empty() || read.csv == csv) << at;
    if (!read.problem.empty()) {
      EXPECT_TRUE(read.problem.starts_with("byte ") || read.problem.starts_with("has no channel"))
          << read.problem;
    }
  }
}

std::string problem_of(std::string_view csv) {
  try {
    to_mcap(csv);
    return "";
  } catch (const files::UserError& error) {
    return error.what();
  }
}

TEST(McapRows, RefuseWhatIsNoTrace) {
  EXPECT_EQ(problem_of(""), "is empty; a trace starts with a row of column names");
  EXPECT_EQ(problem_of("a,b\n1,2\n1\n"), "line 3: the row has 1 columns, the header 2");
  EXPECT_EQ(problem_of("a,b\n1,2\n1,2,3\n"), "line 3: the row has 3 columns, the header 2");
  EXPECT_EQ(problem_of("a,b\n1,2\n1"), "line 3: the row has 1 columns, the header 2");
  EXPECT_EQ(problem_of("a,b\n1,2\n1,2"), "") << "most programs write no end of the last line";
  EXPECT_THAT(problem_of("a,b,a\n1,2,3\n"), HasSubstr("line 1: column 3 (a): another one"));
  EXPECT_THAT(problem_of("a,b\n1,\xff\n"), HasSubstr("line 2: column 2 (b): "));
  EXPECT_THAT(problem_of(std::string(2U << 20U, 'x')), HasSubstr("is this a CSV file?"));
}

TEST(McapRows, RefuseWhatACsvFileCannotHave) {
  const auto problem = [](const std::string& schema, const std::string& message) {
    mcap::Writer writer("test");
    writer.stream({"t", schema, "/trace"});
    writer.message(0, message);
    writer.finish();
    return read_mcap(writer.take()).problem;
  };
  const std::string a = R"({"type":"object","properties":{"a":{"type":"string"}}})";
  EXPECT_EQ(problem(a, R"({"a":"1"})"), "");
  EXPECT_EQ(problem("{}", R"({"b":"1"})"), "");
  EXPECT_THAT(problem(a, R"({"a":"1,2"})"), HasSubstr("message 1: a: '1,2' has a comma"));
  EXPECT_THAT(problem(a, R"({"b":1})"), HasSubstr("has b, which is not among the columns: a"));
  EXPECT_THAT(problem(a, R"({"a":1,"a":2})"), HasSubstr("has a twice"));
  EXPECT_THAT(problem(a, R"({"a":[1]})"), HasSubstr("at 5: an object or a list"));
  EXPECT_THAT(problem(a, "x"), HasSubstr("must be a JSON object"));
  EXPECT_THAT(problem("[", R"({"a":1})"), HasSubstr("schema t: the schema is no JSON object"));
  EXPECT_THAT(problem("{}", "{}"), HasSubstr("has no columns"));
  EXPECT_THAT(problem("{}", R"({"a,b":1})"), HasSubstr("a name cannot have a comma"));
}

TEST(McapRows, RefuseFilesOfAnotherKind) {
  EXPECT_THAT(read_mcap("").problem, StartsWith("byte 0: is no MCAP file"));
  EXPECT_THAT(read_mcap("time_s,current_A\n").problem, StartsWith("byte 0: is no MCAP file"));
  EXPECT_THAT(read_mcap(mcap::magic).problem, HasSubstr("before its header"));
  std::string huge = to_mcap("a\n1\n").substr(0, 8 + 9 + 8 + 14);
  huge += '\x05';
  mcap::put(huge, std::uint64_t{1} << 60U);
  EXPECT_THAT(read_mcap(huge).problem, HasSubstr("a message of 1152921504606846976 bytes"));
}

}  // namespace
}  // namespace smaservo::test
