#include "model/files/text_table.hpp"

#include <algorithm>
#include <gtest/gtest.h>
#include <limits>
#include <nlohmann/json.hpp>

namespace smaservo::test {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

files::TextTable wires() {
  files::TextTable table({{"wire", "", "name"},
                          {"Ø", "{:.0f} µm", "diameter_m", 1e6},
                          {"rows", "{}", "rows"},
                          {.key = "known"},
                          {"remark"}});
  table.add({"thin", 25e-6, 7, true, "at 20 °C"});
  table.add({"a thick one", 381e-6, {1200U, true}, false, {"Δ", true}});
  table.add({"unknown", nan});
  return table;
}

TEST(TextTable, AsText) {
  EXPECT_EQ(wires().text(),
            "wire              Ø   rows   remark\n"
            "thin          25 µm      7   at 20 °C\n"
            "a thick one  381 µm   1200*  Δ\n"
            "unknown           -      -   -\n");
}

TEST(TextTable, AsMarkdown) {
  EXPECT_EQ(wires().markdown(),
            "| wire | Ø | rows | remark |\n"
            "|---|--:|--:|---|\n"
            "| thin | 25 µm | 7 | at 20 °C |\n"
            "| a thick one | 381 µm | **1200** | **Δ** |\n"
            "| unknown | - | - | - |\n");
}

TEST(TextTable, AsHtml) {
  EXPECT_EQ(wires().html(),
            "<table>\n"
            "<thead><tr><th>wire</th><th>Ø</th><th>rows</th><th>remark</th></tr>\n</thead>\n"
            "<tr><td>thin</td><td>25 µm</td><td>7</td><td>at 20 °C</td></tr>\n"
            "<tr><td>a thick one</td><td>381 µm</td><td class=\"lost\">1200</td>"
            "<td class=\"lost\">Δ</td></tr>\n"
            "<tr><td>unknown</td><td>-</td><td>-</td><td>-</td></tr>\n"
            "</table>\n");
}

/// The numbers as they were given, in the order of the columns.
TEST(TextTable, AsJson) {
  EXPECT_EQ(wires().json().dump(),
            R"([{"name":"thin","diameter_m":2.5e-05,"rows":7,"known":true},)"
            R"({"name":"a thick one","diameter_m":0.000381,"rows":1200,"known":false},)"
            R"({"name":"unknown","diameter_m":null,"rows":null,"known":null}])");
}

TEST(TextTable, NumbersOfEveryType) {
  files::TextTable table(
      {{"", "{:.1f}", "a"}, {"", "", "b"}, {"c", "{:.1f}", "c"}, {"d", "{}", "d"}});
  table.add({1.25F, -3, std::uint64_t{1} << 63U, std::numeric_limits<double>::infinity()});
  EXPECT_EQ(table.json().dump(), R"([{"a":1.25,"b":-3,"c":9223372036854775808,"d":null}])");
  EXPECT_EQ(table.text(),
            "                  c    d\n"
            "9223372036854775808  inf\n");
  files::TextTable truth({{"a"}, {"b"}});
  truth.add({true, false});
  EXPECT_EQ(truth.text(), "a    b\nyes  no\n");
}

/// A real number without a format has as many digits as it needs.
TEST(TextTable, NumbersWithoutAFormat) {
  files::TextTable table({{"a"}});
  table.add({0.1});
  EXPECT_EQ(table.text(), "a\n0.1\n");
}

TEST(TextTable, WithoutRows) {
  const files::TextTable table({{"wire", "", "name"}, {"rows", "{}"}});
  EXPECT_TRUE(table.empty());
  EXPECT_EQ(table.text(), "wire  rows\n");
  EXPECT_EQ(table.markdown(), "| wire | rows |\n|---|--:|\n");
  EXPECT_EQ(table.html(),
            "<table>\n<thead><tr><th>wire</th><th>rows</th></tr>\n</thead>\n</table>\n");
  EXPECT_EQ(table.json().dump(), "[]");
  EXPECT_FALSE(wires().empty());
}

TEST(TextTable, WithoutHeadings) {
  files::TextTable table({{""}, {"", "{:.1f}"}});
  table.add({"one", 1});
  table.add({"eleven", 11.25});
  EXPECT_EQ(table.text(), "one        1\neleven  11.2\n");
  EXPECT_EQ(table.html(),
            "<table>\n<tr><td>one</td><td>1</td></tr>\n"
            "<tr><td>eleven</td><td>11.2</td></tr>\n</table>\n");
}

TEST(TextTable, WhatStandsWhereThereIsNothing) {
  files::TextTable table({{"a"}, {"b", "{:.1f}"}, {"c", "{}"}}, "never");
  table.add({"x", nan, {}});
  EXPECT_EQ(table.markdown(), "| a | b | c |\n|---|--:|--:|\n| x | never | never |\n");
}

/// If a cell of a right-aligned column has a star, the other cells get a space there, so that
/// digits stay below each other. Left-aligned cells have no star.
TEST(TextTable, StarsStandBehindTheirColumn) {
  files::TextTable table({{"a"}, {"b", "{}"}, {"c", "{}"}});
  table.add({{"x", true}, 1, 2});
  EXPECT_EQ(table.text(), "a  b  c\nx  1  2\n");
  table.add({"y", {10, true}, 3});
  EXPECT_EQ(table.text(), "a   b   c\nx   1   2\ny  10*  3\n");
}

TEST(TextTable, EveryFormatEscapesItsOwn) {
  files::TextTable table({{"a|b"}, {"<c>\x1B", "", "c\""}});
  table.add({"x|y & z", "<b>\"\n\x1B[2J\xFF|"});
  EXPECT_EQ(table.text(), "a|b      <c>\\x1B\nx|y & z  <b>\"\\x0A\\x1B[2J\\xFF|\n");
  EXPECT_EQ(table.markdown(),
            "| a\\|b | &lt;c>\\x1B |\n|---|---|\n| x\\|y & z | &lt;b>\"\\x0A\\x1B[2J\\xFF\\| |\n");
  EXPECT_EQ(table.html(),
            "<table>\n<thead><tr><th>a|b</th><th>&lt;c&gt;\\x1B</th></tr>\n</thead>\n"
            "<tr><td>x|y &amp; z</td><td>&lt;b&gt;&quot;\\x0A\\x1B[2J\\xFF|</td></tr>\n</table>\n");
  EXPECT_EQ(nlohmann::json::parse(files::json_text(table.json()))[0]["c\""],
            "<b>\"\n\x1B[2J\xEF\xBF\xBD|");
}

files::TextTable broad(std::size_t columns) {
  std::vector<files::TextTable::Column> all{{"which"}};
  files::TextTable::Row row{"µ°±Δ"};
  for (std::size_t i = 0; i < columns; ++i) {
    all.push_back({"greatest µ by far", "{:.2f}"});
    row.emplace_back(1000.5);
  }
  files::TextTable table(std::move(all));
  table.add(std::move(row));
  return table;
}

TEST(TextTable, HeadingsAreBrokenWhereThatKeepsIt80ColumnsWide) {
  EXPECT_EQ(broad(1).text(), "which  greatest µ by far\nµ°±Δ             1000.50\n");
  const std::string text = broad(7).text();
  EXPECT_EQ(text,
            "       greatest  greatest  greatest  greatest  greatest  greatest  greatest\n"
            "           µ by      µ by      µ by      µ by      µ by      µ by      µ by\n"
            "which       far       far       far       far       far       far       far\n"
            "µ°±Δ    1000.50   1000.50   1000.50   1000.50   1000.50   1000.50   1000.50\n");
  const std::string hopeless = broad(8).text();
  EXPECT_EQ(std::ranges::count(hopeless, '\n'), 2);
}

}  // namespace
}  // namespace smaservo::test
