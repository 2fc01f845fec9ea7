// `host-sim figures` as its user meets it.

#include <filesystem>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <string_view>

#include "tests/host-sim/program.hpp"

namespace smaservo::test {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using Texts = Program::Texts;

std::size_t count(std::string_view text, std::string_view part) {
  std::size_t found = 0;
  for (std::size_t at = text.find(part); at != std::string_view::npos;
       at = text.find(part, at + part.size())) {
    ++found;
  }
  return found;
}

struct Tag {
  std::string_view name;  ///< empty at the end of the text
  bool closes, stands_alone;
};

/// Takes everything up to and with the next tag off the text; comments and declarations are none.
Tag next_tag(std::string_view& text) {
  const auto take_to = [&](std::string_view end) {
    const std::size_t at = text.find(end);
    const std::string_view taken =
        text.substr(0, at == std::string_view::npos ? at : at + end.size());
    text.remove_prefix(taken.size());
    return taken;
  };
  for (take_to("<"); !text.empty(); take_to("<")) {
    if (text.starts_with("!--")) {
      take_to("-->");
    } else if (text.starts_with("![CDATA[")) {
      take_to("]]>");
    } else {
      std::string_view tag = take_to(">");
      if (tag.front() != '?' && tag.front() != '!') {
        const bool closes = tag.front() == '/';
        tag.remove_prefix(closes ? 1 : 0);
        return {tag.substr(0, tag.find_first_of(" \t\n/>")), closes, tag.ends_with("/>")};
      }
    }
  }
  return {"", false, false};
}

/// Whether every tag is closed in its order, and the outermost one is svg.
bool is_well_formed_svg(std::string_view text) {
  std::vector<std::string_view> open;
  bool svg = false;
  for (Tag tag = next_tag(text); !tag.name.empty(); tag = next_tag(text)) {
    svg = svg || (open.empty() && tag.name == "svg");
    if (tag.closes) {
      if (open.empty() || open.back() != tag.name) {
        return false;
      }
      open.pop_back();
    } else if (!tag.stands_alone) {
      open.push_back(tag.name);
    }
  }
  return svg && open.empty();
}

TEST(Svg, WellFormedOrNot) {
  EXPECT_TRUE(is_well_formed_svg("<?xml?><svg><g a=\"b\"/><g>t</g><!-- <x> --></svg>"));
  EXPECT_FALSE(is_well_formed_svg("<svg><g></svg>"));
  EXPECT_FALSE(is_well_formed_svg("<svg><g></g>"));
  EXPECT_FALSE(is_well_formed_svg("<html></html>"));
  EXPECT_FALSE(is_well_formed_svg(""));
}

TEST(FiguresCommand, WritesAPageAndOneSvgForEachPanel) {
  Program program;
  const Finished f = program.run({"figures", "--out", "new/folder", "--paper", "000"});
  ASSERT_EQ(f.status, 0) << f.err;
  EXPECT_EQ(f.out, "new/folder/index.html\n");
  const std::filesystem::path folder = program.folder().path() / "new/folder";
  const std::string page = file_text(folder / "index.html");
  std::size_t pictures = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    if (name == "index.html") {
      continue;
    }
    ++pictures;
    EXPECT_TRUE(name.starts_with("000-") && name.ends_with(".svg")) << name;
    EXPECT_TRUE(is_well_formed_svg(file_text(entry.path()))) << name;
  }
  EXPECT_GE(pictures, 15U);
  EXPECT_EQ(count(page, "<img"), pictures);
  for (const int figure : {1, 2, 5, 6, 8, 9, 10, 13, 14, 15, 16, 17, 18, 19, 20}) {
    EXPECT_THAT(page, HasSubstr("000, figure " + std::to_string(figure) + ":"));
  }
  EXPECT_EQ(count(page, "<h3>"), 15U);
  EXPECT_THAT(page, Not(HasSubstr("http:")));  // needs no network
  EXPECT_THAT(page, Not(HasSubstr("https:")));
}

TEST(FiguresCommand, RefusesAnUnknownPaperBeforeItWrites) {
  Program program;
  const Finished f = program.run({"figures", "--out", "here", "--paper", "000", "--paper", "999"});
  EXPECT_EQ(f.status, 1);
  EXPECT_EQ(f.out, "");
  EXPECT_THAT(f.err, HasSubstr("host-sim: --paper 999: no such paper; there are: 000"));
  EXPECT_THAT(program.folder().names(), IsEmpty());
}

TEST(FiguresCommand, RefusesAFolderThatCanNotBeWritten) {
  Program program;
  program.folder().write("file", "mine");
  for (const char* out : {"file", "file/below", "/proc/figures"}) {
    const Finished f = program.run({"figures", "--out", out, "--paper", "000"});
    EXPECT_EQ(f.status, 1) << out;
    EXPECT_EQ(f.out, "");
    EXPECT_THAT(f.err, HasSubstr(std::string("host-sim: --out ") + out + ": "));
  }
  EXPECT_EQ(file_text(program.folder().path() / "file"), "mine");
  EXPECT_EQ(program.folder().names().size(), 1U);
}

TEST(FiguresCommand, WithoutGnuplotThereIsNothing) {
  Program program;
  program.environment = {"PATH=" + program.folder().path().string()};
  const Finished f = program.run({"figures", "--out", "here", "--paper", "000"});
  EXPECT_EQ(f.status, 1);
  EXPECT_THAT(f.err, HasSubstr("gnuplot"));
  EXPECT_TRUE(std::filesystem::is_empty(program.folder().path() / "here"));
}

TEST(FiguresCommand, WhatFailsHalfWayLeavesWholePicturesAndTheOldPage) {
  Program program;
  const std::filesystem::path folder = program.folder().path() / "here";
  std::filesystem::create_directories(folder / "000-05-a.svg" / "in the way");
  program.folder().write("here/index.html", "old");
  const Finished f = program.run({"figures", "--out", "here", "--paper", "000"});
  EXPECT_EQ(f.status, 1);
  EXPECT_THAT(f.err, HasSubstr("000-05-a.svg"));
  EXPECT_EQ(file_text(folder / "index.html"), "old");
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    if (entry.is_regular_file() && name != "index.html") {
      EXPECT_TRUE(name.ends_with(".svg") && is_well_formed_svg(file_text(entry.path()))) << name;
    }
  }
}

}  // namespace
}  // namespace smaservo::test
