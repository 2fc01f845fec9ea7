#include "model/files/message.hpp"

#include <cstdint>
#include <fcntl.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <string>
#include <toml++/toml.h>
#include <unistd.h>
#include <vector>

#include "model/files/text_table.hpp"
#include "model/files/toml/toml_fields.hpp"

namespace {

using namespace smaservo;

/// U+202E, which turns the direction of writing; byte by byte, so that this text stays readable.
std::string turned() {
  return {'\xE2', '\x80', '\xAE'};
}

TEST(Message, PrintableKeepsSymbolsAndNothingElse) {
  EXPECT_EQ(files::printable("µ ° ± Δ € 😀 ~ \\ '"), "µ ° ± Δ € 😀 ~ \\ '");
  EXPECT_EQ(files::printable(""), "");
  EXPECT_EQ(files::printable("\x1B[2J\t\x7F"), "\\x1B[2J\\x09\\x7F");
  EXPECT_EQ(files::printable("\xC2\x9B"
                             "2J"),
            "\\xC2\\x9B2J")
      << "a control character of Latin-1";
  EXPECT_EQ(files::printable("\xE2\x82"), "\\xE2\\x82") << "cut off";
  EXPECT_EQ(files::printable("\x80"
                             "a\xC3"
                             "b"),
            "\\x80a\\xC3b");
  EXPECT_EQ(files::printable("\xC0\x9B \xE0\x82\x9B \xF0\x80\x82\x9B \xF5\x80\x80\x80"),
            "\\xC0\\x9B \\xE0\\x82\\x9B \\xF0\\x80\\x82\\x9B \\xF5\\x80\\x80\\x80")
      << "forms that are too long, and what lies beyond the last symbol";
  EXPECT_EQ(files::printable("\xED\xA0\x80"), "\\xED\\xA0\\x80") << "half a pair of UTF-16";
  EXPECT_EQ(files::printable("a\u2028b" + turned() + "c\uFEFF"),
            "a\\xE2\\x80\\xA8b\\xE2\\x80\\xAEc\\xEF\\xBB\\xBF")
      << "breaks the line, turns the direction, has no width";
}

/// Whatever comes in: one line, within the bound, of valid UTF-8 without control characters; and
/// nothing changes when a caller and a callee both make it printable.
TEST(Message, PrintableOfRandomBytesIsOneLine) {
  std::uint64_t state = 1;
  const auto random = [&](unsigned below) {
    state = state * 6364136223846793005U + 1442695040888963407U;
    return static_cast<unsigned>(state >> 33U) % below;
  };
  for (int i = 0; i < 300; ++i) {
    std::string text;
    for (unsigned left = random(i % 10 == 0 ? 20'000 : 60); left > 0; --left) {
      text += static_cast<char>(random(3) == 0 ? random(256) : 0x20 + random(0x5F));
    }
    const std::string out = files::printable(text);
    EXPECT_LE(out.size(), files::longest_message);
    EXPECT_EQ(files::printable(out), out);
    EXPECT_EQ(out.find_first_of(std::string("\n\r\x1B\x7F\0", 5)), std::string::npos);
    EXPECT_NO_THROW(nlohmann::json(out).dump()) << "throws where it is no UTF-8";
  }
}

TEST(Message, OfALongTextHeadAndTailAreShown) {
  const std::string text = "begins" + std::string(1'000'000, '\x1B') + "ends";
  const std::string out = files::printable(text);
  EXPECT_LE(out.size(), files::longest_message);
  EXPECT_TRUE(out.starts_with("begins\\x1B"));
  EXPECT_TRUE(out.ends_with("\\x1Bends"));
  EXPECT_NE(out.find("[... 1000010 bytes in all ...]"), std::string::npos);
  const std::string fits(files::longest_message, 'x');
  EXPECT_EQ(files::printable(fits), fits);
}

TEST(Message, ATextOfLinesKeepsItsLines) {
  EXPECT_EQ(files::printable_lines("a\n\x1B[2J\r\nb\n"), "a\n\\x1B[2J\\x0D\nb\n");
}

/// A document that a terminal may show is the same document.
TEST(Message, JsonStaysJson) {
  const std::string text = "\x1B\n\x7F\xC2\x9B" + turned() + "\U000E0041µ";
  const nlohmann::ordered_json json{{text, text}};
  for (const int indent : {-1, 2}) {
    const std::string document = files::json_text(json, indent);
    EXPECT_EQ(nlohmann::ordered_json::parse(document), json);
    EXPECT_EQ(files::printable_lines(document), document);
  }
  EXPECT_NE(files::json_text({"\xFF"}, -1), "") << "no UTF-8, which the library would refuse";
}

/// No string ends its quotes or its line, as a value or as a key.
TEST(Message, TomlStringsComeBack) {
  const std::vector<std::string> texts{"a",
                                       "a\nb = 2",
                                       "\"",
                                       "\\",
                                       "\"\"\"\n",
                                       "'''",
                                       "\x1B\x7F\xC2\x9B",
                                       turned() + "\U000E0041µ",
                                       "\r",
                                       "ends in \\"};
  for (const std::string& text : texts) {
    const std::string line = fmt::format("{0} = {0}\n", files::quoted(text));
    EXPECT_EQ(files::printable(line.substr(0, line.size() - 1)) + "\n", line);
    const toml::table table = toml::parse(line);
    ASSERT_EQ(table.size(), 1U) << line;
    EXPECT_EQ(table.begin()->first.str(), text);
    EXPECT_EQ(table.begin()->second.value<std::string>(), text);
  }
}

TEST(Message, OnTheErrorOutputIsOneLine) {
  testing::internal::CaptureStderr();
  files::complain("program", "file\x1B[2J\nprogram: all is well");
  EXPECT_EQ(testing::internal::GetCapturedStderr(),
            "program: file\\x1B[2J\\x0Aprogram: all is well\n");
  testing::internal::CaptureStderr();
  files::redraw("a\x1B[2J");
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "\r\033[Ka\\x1B[2J");
}

/// In a process of its own: whichever of the three are closed, what is opened next gets none of
/// their numbers, and writing to them fails.
TEST(StandardDescriptors, AreNobodyElses) {
  for (unsigned closed = 0; closed < 8; ++closed) {
    const auto child = [closed] {
      for (int fd = 0; fd < 3; ++fd) {
        if ((closed >> static_cast<unsigned>(fd) & 1U) != 0) {
          close(fd);
        }
      }
      files::hold_standard_descriptors();
      const int next = open("/dev/null", O_WRONLY);
      const bool stdout_closed = (closed & 2U) != 0;
      const bool written = write(STDOUT_FILENO, "", 1) == 1;
      _exit(next > STDERR_FILENO && written != stdout_closed ? 0 : 1);
    };
    EXPECT_EXIT(child(), ::testing::ExitedWithCode(0), "") << closed;
  }
}

}  // namespace
