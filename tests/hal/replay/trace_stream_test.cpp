// Traces as streams: pipes, chunks of any size, long lines, damaged files.

#include <algorithm>
#include <bit>
#include <cmath>
#include <functional>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <random>
#include <ranges>
#include <stdexcept>
#include <sys/socket.h>
#include <thread>
#include <unistd.h>

#include "tests/hal/recording/mcap/files.hpp"
#include "tests/hal/replay/traces.hpp"

namespace smaservo::test::trace_stream_test {
namespace {

using ::testing::HasSubstr;

using Random = std::mt19937_64;

std::size_t up_to(Random& random, std::size_t max) {
  return std::uniform_int_distribution<std::size_t>(0, max)(random);
}

/// Standard input that gives exactly the pieces that `write` sends: a packet is read at once.
class PiecewiseInput {
 public:
  using Send = std::function<void(std::string_view)>;

  explicit PiecewiseInput(const std::function<void(const Send&)>& write) {
    int ends[2];
    if (socketpair(AF_UNIX, SOCK_SEQPACKET, 0, ends) != 0) {
      throw std::runtime_error("no socket pair");
    }
    saved_ = dup(STDIN_FILENO);
    dup2(ends[0], STDIN_FILENO);
    close(ends[0]);
    writer_ = std::thread([out = ends[1], write] {
      write([out](std::string_view piece) {
        // It is no error of the writer if the reader has given up.
        static_cast<void>(send(out, piece.data(), piece.size(), MSG_NOSIGNAL));
      });
      close(out);
    });
  }
  ~PiecewiseInput() {
    // The only reading end is closed first, which frees a writer that waits.
    dup2(saved_, STDIN_FILENO);
    close(saved_);
    writer_.join();
  }
  PiecewiseInput(const PiecewiseInput&) = delete;
  PiecewiseInput& operator=(const PiecewiseInput&) = delete;

 private:
  int saved_ = -1;
  std::thread writer_;
};

std::string good_trace(int rows) {
  std::string text = "\xEF\xBB\xBFtime_s,current_mA,note,voltage_V\r\n";
  for (int i = 0; i < rows; ++i) {
    const std::string number = std::to_string(i);
    text += number + "," + std::to_string(100 + i % 7) + ".25,n" + number + "," +
            std::to_string(2 + i % 3) + "e-1" + (i % 5 == 0 ? "\r\n" : "\n");
  }
  return text;
}

bool same(double a, double b) {
  return a == b || (std::isnan(a) && std::isnan(b));
}

void expect_same(const TraceContents& a, const TraceContents& b) {
  EXPECT_EQ(a.texts, b.texts);
  ASSERT_EQ(a.rows.size(), b.rows.size());
  for (std::size_t i = 0; i < a.rows.size(); ++i) {
    ASSERT_TRUE(std::ranges::equal(a.rows[i], b.rows[i], same)) << "row " << i;
  }
  EXPECT_EQ(a.complaints, b.complaints);
  EXPECT_EQ(a.skipped, b.skipped);
}

TEST(TraceStream, PiecesOfAnySizeGiveTheSameRows) {
  std::string text = good_trace(2000);
  text += "bad line\n\n99999,1,x,2\n";
  hal::TraceOptions options;
  options.lenient = true;
  const TraceContents expected = read_trace(text, options);
  ASSERT_EQ(expected.rows.size(), 2001U);
  ASSERT_EQ(expected.skipped, 1U);
  for (const std::size_t largest : {1UL, 2UL, 17UL, 1000UL, 100'000UL}) {
    const PiecewiseInput input([&](const PiecewiseInput::Send& send) {
      Random random(largest);
      for (std::size_t at = 0; at < text.size();) {
        const std::size_t size = 1 + up_to(random, largest - 1);
        send(std::string_view(text).substr(at, size));
        at += size;
      }
    });
    hal::TraceReader reader("-", options);
    expect_same(read_all(reader), expected);
    EXPECT_EQ(reader.bytes(), text.size());
    EXPECT_EQ(reader.file_size(), 0U) << "nobody knows how much a pipe will give";
  }
}

TEST(TraceStream, StandardInputIsCalledSo) {
  const PiecewiseInput input([](const PiecewiseInput::Send& send) { send("time_s\n0\nx\n"); });
  hal::TraceReader reader("-", {});
  try {
    read_all(reader);
    FAIL() << "x is no number";
  } catch (const hal::TraceError& error) {
    EXPECT_STREQ(error.what(),
                 "standard input: line 3, column 1 (time_s): 'x' is not a finite number");
  }
}

TEST(TraceStream, FileSizeIsKnownAndReadToItsEnd) {
  const TemporaryFolder folder;
  const std::string text = good_trace(10);
  hal::TraceReader reader(folder.write("t.csv", text), {});
  EXPECT_EQ(reader.file_size(), text.size());
  EXPECT_EQ(read_all(reader).rows.size(), 10U);
  EXPECT_EQ(reader.bytes(), text.size());
  EXPECT_EQ(reader.rows(), 10U);
  hal::TraceRow row{};
  EXPECT_FALSE(reader.next(row)) << "the end stays the end";
}

TEST(TraceStream, MemoryDoesNotGrowWithTheTrace) {
  constexpr int blocks = 300;
  constexpr int rows = 2000;  // rows of at least 32 bytes: 20 MB in total
  const PiecewiseInput input([](const PiecewiseInput::Send& send) {
    send("time_s,note\n");
    std::string block;
    for (int b = 0; b < blocks; ++b) {
      block.clear();
      for (int i = 0; i < rows; ++i) {
        block += std::to_string(b * rows + i) + ",abcdefghijklmnopqrstuvwxyz\n";
      }
      send(block);
    }
  });
  hal::TraceReader reader("-", {});
  hal::TraceRow row{};
  ASSERT_TRUE(reader.next(row));
  auto low = std::bit_cast<std::uintptr_t>(row.text.data());
  auto high = low + row.text.size();
  while (reader.next(row)) {
    const auto at = std::bit_cast<std::uintptr_t>(row.text.data());
    low = std::min(low, at);
    high = std::max(high, at + row.text.size());
  }
  EXPECT_EQ(reader.rows(), static_cast<std::uint64_t>(blocks) * rows);
  EXPECT_GT(reader.bytes(), 19'000'000U);
  EXPECT_LE(high - low, std::uintptr_t{1} << 20) << "every row's text lies in one buffer of 1 MiB";
}

TEST(TraceStream, ALineMayFillTheBufferButNotMore) {
  const std::string long_note(1'000'000, 'n');
  const TraceContents t = read_trace("time_s,note\n0,a\n1," + long_note + "\n2,b\n");
  ASSERT_EQ(t.texts.size(), 3U);
  EXPECT_EQ(t.texts[1], "1," + long_note);
  const std::string endless = "time_s,note\n0,a\n1," + std::string(2'000'000, 'n') + "\n2,b\n";
  hal::TraceOptions lenient;
  lenient.lenient = true;
  for (const hal::TraceOptions& options : {hal::TraceOptions{}, lenient}) {
    EXPECT_EQ(refusal(endless, options), "line 3: longer than 1048576 bytes; is this a CSV file?");
  }
}

TEST(TraceStream, BinaryJunkIsRefused) {
  Random random(7);
  std::string junk(100'000, '\0');
  std::ranges::generate(junk, [&] { return static_cast<char>(up_to(random, 255)); });
  EXPECT_NE(refusal("time_s\n" + junk + "\n"), "");
  hal::TraceOptions options;
  options.lenient = true;
  EXPECT_THAT(refusal("time_s,current_A\n" + junk + "\n", options), HasSubstr("more than half"));
}

std::string mutated(std::string text, Random& random) {
  for (std::size_t changes = 1 + up_to(random, 4); changes > 0; --changes) {
    const std::size_t at = up_to(random, text.size() - 1);
    constexpr std::string_view likely = ",,\n\n\r.-+e0919 \"xn";
    const char byte = up_to(random, 1) == 0 ? likely[up_to(random, likely.size() - 1)]
                                            : static_cast<char>(up_to(random, 255));
    switch (up_to(random, 4)) {
      case 0:
        text.erase(at, 1 + up_to(random, 20));
        break;
      case 1:
        text.insert(at, 1 + up_to(random, 3), byte);
        break;
      case 2:
        text.insert(at, text.substr(up_to(random, text.size() - 1), up_to(random, 60)));
        break;
      default:
        text[at] = byte;
    }
    if (text.empty()) {
      return text;
    }
  }
  return text;
}

struct Outcome {
  TraceContents contents;
  std::string error;  ///< empty when it was read to the end
  bool clock_fell = false;
  bool cut_off = false;  ///< the last line, which was skipped
};

Outcome read_until_error(const std::string& path, const hal::TraceOptions& options) {
  Outcome outcome;
  try {
    hal::TraceReader reader(path, options);
    hal::TraceRow row{};
    while (reader.next(row)) {
      outcome.contents.rows.push_back(row.values);
      outcome.contents.texts.emplace_back(row.text);
    }
    outcome.contents.skipped = reader.skipped();
    const std::vector<std::string>& complaints = reader.complaints();
    outcome.cut_off = !complaints.empty() && complaints.back().ends_with("cut off there");
    outcome.clock_fell = !reader.clock_notes().empty();
  } catch (const hal::TraceError& error) {
    outcome.error = error.what();
  }
  return outcome;
}

/// What holds for every row that was let through.
void expect_sound(const TraceContents& t) {
  double last_s = -std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < t.rows.size(); ++i) {
    const double time_s = t.at(i, hal::Column::time);
    ASSERT_TRUE(std::isnan(time_s) || time_s > last_s);
    last_s = std::isnan(time_s) ? last_s : time_s;
    ASSERT_FALSE(std::abs(t.at(i, hal::Column::current)) > 1e3);
    ASSERT_FALSE(std::abs(t.at(i, hal::Column::voltage)) > 1e4);
  }
}

TEST(TraceStream, DamagedTracesNeverCrash) {
  const std::string good = good_trace(12);
  const TemporaryFolder folder;
  Random random(8);
  hal::TraceOptions lenient;
  lenient.lenient = true;
  int refused = 0;
  int skipped = 0;
  for (int i = 0; i < 1500; ++i) {
    const std::string text = mutated(good, random);
    SCOPED_TRACE(text);
    const std::string path = folder.write("t.csv", text);
    const Outcome strict = read_until_error(path, {});
    const Outcome forgiving = read_until_error(path, lenient);
    expect_sound(forgiving.contents);
    if (!forgiving.error.empty()) {
      const bool of_header = forgiving.error.find(": line 1, column ") != std::string::npos;
      ASSERT_TRUE(text.empty() || of_header ||
                  forgiving.error.find("more than half") != std::string::npos)
          << forgiving.error;
      ASSERT_TRUE(!of_header || strict.error == forgiving.error);
      continue;
    }
    // Both skip a last line that is cut off.
    ASSERT_TRUE(!strict.error.empty() || strict.cut_off == forgiving.cut_off);
    const bool any_bad =
        forgiving.contents.skipped > (forgiving.cut_off ? 1U : 0U) || forgiving.clock_fell;
    ASSERT_EQ(strict.error.empty(), !any_bad);
    // Both read the same up to the first bad row. A strict reader refuses the row after a time that
    // was too late, so the bad row may be one before the line that it refuses.
    const std::size_t read = strict.contents.texts.size();
    const std::size_t same = strict.error.empty() || read == 0 ? read : read - 1;
    ASSERT_LE(same, forgiving.contents.texts.size());
    ASSERT_TRUE(std::ranges::equal(
        std::views::take(strict.contents.texts, static_cast<std::ptrdiff_t>(same)),
        std::views::take(forgiving.contents.texts, static_cast<std::ptrdiff_t>(same))));
    refused += strict.error.empty() ? 0 : 1;
    skipped += any_bad ? 1 : 0;
  }
  EXPECT_GT(refused, 400);
  EXPECT_EQ(refused, skipped);
}

// MCAP: the same rows, whatever the file is called and wherever it comes from.

constexpr const char* rows_text =
    "time_s,current_A,voltage_V,load_N,note\n0.000,0.1,2.5,,at rest\n0.010,0.2,5.0,1.5,\n";

hal::TraceOptions of_a_device() {
  hal::TraceOptions options;
  options.device = true;
  return options;
}

TEST(TraceMcap, HasTheRowsOfTheText) {
  const TemporaryFolder folder;
  const std::string bytes = to_mcap(rows_text);
  for (const char* name : {"t.mcap", "t.csv"}) {
    hal::TraceReader mcap(folder.write(name, bytes), of_a_device());
    EXPECT_EQ(mcap.names(),
              (std::vector<std::string>{"time_s", "current_A", "voltage_V", "load_N", "note"}));
    EXPECT_EQ(mcap.file_size(), bytes.size());
    const TraceContents read = read_all(mcap);
    EXPECT_EQ(mcap.bytes(), bytes.size());
    EXPECT_EQ(read.texts, read_trace(rows_text, of_a_device()).texts);
    EXPECT_EQ(read.at(1, hal::Column::load), 1.5);
    EXPECT_TRUE(std::isnan(read.at(0, hal::Column::load)));
    EXPECT_EQ(read.skipped, 0U);
  }
}

TEST(TraceMcap, MessagesNameTheMessage) {
  EXPECT_EQ(refusal(to_mcap("time_s,current_A\n0,1\n1,x\n")),
            "message 2, column 2 (current_A): 'x' is not a finite number");
  EXPECT_EQ(refusal(to_mcap("time_s,time_ms\n0,1\n")),
            "schema, column 2 (time_ms): there is another column for time");
}

TEST(TraceMcap, ARecordingWithoutItsEndIsReadAndSaysSo) {
  const std::string bytes = to_mcap(rows_text);
  // The last 100 bytes are summary and end.
  const TraceContents read =
      read_trace(std::string_view(bytes).substr(0, bytes.size() - 100), of_a_device());
  EXPECT_EQ(read.rows.size(), 2U);
  EXPECT_EQ(read.skipped, 1U);
  ASSERT_EQ(read.complaints.size(), 1U);
  EXPECT_TRUE(read.complaints[0].ends_with("it was not finished, or is cut off"));
}

TEST(TraceMcap, DamageAndOtherFilesOfThisNameAreRefused) {
  std::string bytes = to_mcap(rows_text);
  bytes[bytes.size() / 4] = static_cast<char>(bytes[bytes.size() / 4] ^ 1);
  EXPECT_TRUE(refusal(bytes).starts_with("byte ")) << refusal(bytes);
  const TemporaryFolder folder;
  try {
    const hal::TraceReader reader(folder.write("t.mcap", rows_text), {});
    FAIL();
  } catch (const hal::TraceError& error) {
    EXPECT_EQ(
        error.what(),
        folder / "t.mcap" + ": byte 0: is no MCAP file: must begin with 89 4D 43 41 50 30 0D 0A");
  }
}

}  // namespace
}  // namespace smaservo::test::trace_stream_test
