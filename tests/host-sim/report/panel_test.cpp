#include "host-sim/report/panel.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <limits>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "host-sim/report/assets.hpp"
#include "host-sim/report/html.hpp"
#include "host-sim/report/panel_json.hpp"
#include "host-sim/report/picture.hpp"

namespace smaservo::test {
namespace {

using report::Kind;
using report::Panel;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr const char* nasty = "</script><script>alert('1')</script><!--";

report::Column ramp(std::size_t rows) {
  std::vector<double> values(rows);
  for (std::size_t i = 0; i < rows; ++i) {
    values[i] = static_cast<double>(i);
  }
  return report::column(std::move(values));
}

/// One series of each kind, with names that want to be something else.
Panel everything() {
  const report::Column x = report::column({0, 1, 2, nan, 4, 5});
  const report::Column y = report::column({0, 1e-3, 7.6e-05, nan, 1, 2});
  const report::Column low = report::column({0, 0, 0, nan, 0.5, 1});
  Panel panel{.title = nasty,
              .caption = nasty,
              .x = {.label = nasty, .min = -1, .max = 6},
              .y = {.label = "y"},
              .right = {.label = "right"},
              .link = "time"};
  panel.series = {
      {.name = "band", .colour = "band", .kind = Kind::band, .x = x, .y = y, .low = low},
      {.name = "area", .colour = "r_phase", .kind = Kind::area, .x = x, .y = y, .low = low},
      {.name = nasty, .colour = "estimate", .x = x, .y = y, .dashed = true},
      {.name = "steps", .colour = "#123456", .kind = Kind::steps, .x = x, .y = y},
      {.name = "points", .colour = "fault", .kind = Kind::points, .x = x, .y = y, .right = true}};
  panel.rules = {{1.5, "limit", "fault"}, {3, "", "ink", true}};
  panel.notes = {{2, 1, nasty}};
  return panel;
}

Panel spans() {
  return {.title = "spans",
          .x = {.min = 0, .max = 10},
          .series = {{.name = "wire_open'\"",
                      .colour = "fault",
                      .kind = Kind::spans,
                      .x = report::column({1, 5}),
                      .y = report::column({1, 8})}}};
}

nlohmann::json json_of(const std::vector<Panel>& panels) {
  return nlohmann::json::parse(report::panels_json(panels));
}

TEST(Panels, TheirPicturesShowEveryKind) {
  const std::vector<Panel> panels{everything(), spans(), {.title = "empty"}};
  const std::vector<std::string> svg = report::pictures(panels);
  ASSERT_EQ(svg.size(), 3U);
  for (const char* part : {"band", "area", "steps", "points", "limit", "right", "alert"}) {
    EXPECT_THAT(svg[0], HasSubstr(part));
  }
  EXPECT_THAT(svg[0], Not(HasSubstr("<script>alert")));
  EXPECT_THAT(svg[1], HasSubstr("wire_open"));
  EXPECT_THAT(svg[2], HasSubstr("</svg>"));
}

TEST(Panels, ABadColourAndUnequalColumnsAreMistakesOfThePrograms) {
  Panel panel{.title = "", .series = {{.colour = "mauve", .x = ramp(3), .y = ramp(3)}}};
  EXPECT_THROW((void)report::pictures(std::vector{panel}), std::logic_error);
  panel.series.front() = {.colour = "estimate", .x = ramp(3), .y = ramp(4)};
  EXPECT_THROW((void)report::pictures(std::vector{panel}), std::logic_error);
  EXPECT_THROW((void)report::panels_json(std::vector{panel}), std::logic_error);
}

TEST(PanelsJson, SaysWhatThePanelsSay) {
  Panel picture{.title = "a picture", .svg = "<svg></svg>"};
  const nlohmann::json json = json_of({everything(), picture, spans()});
  EXPECT_TRUE(json["panels"][1].is_null());
  const nlohmann::json& panel = json["panels"][0];
  EXPECT_EQ(panel["title"], nasty);
  EXPECT_EQ(panel["x"]["min"], -1);
  EXPECT_EQ(panel["link"], "time");
  EXPECT_EQ(panel["notes"][0][2], nasty);
  EXPECT_EQ(panel["rules"][1]["vertical"], true);
  const std::vector<std::string> kinds{"band", "area", "line", "steps", "points"};
  for (std::size_t i = 0; i < kinds.size(); ++i) {
    EXPECT_EQ(panel["series"][i]["kind"], kinds[i]);
    EXPECT_EQ(panel["series"][i]["x"], panel["series"][0]["x"]) << "one column, once in the page";
  }
  EXPECT_EQ(json["columns"].size(), 3U + 2U);
  const std::size_t y = panel["series"][0]["y"];
  EXPECT_EQ(json["columns"][y].dump(), "[0,0.001,7.6e-05,null,1,2]");
}

// Nothing that came from outside ends the element that the data stand in, or begins a comment.
TEST(PanelsJson, HasNoMarkup) {
  const std::string text = report::panels_json(std::vector{everything()});
  EXPECT_THAT(text, Not(HasSubstr("<")));
  EXPECT_THAT(text, HasSubstr("\\u003c/script>"));
}

TEST(PanelsJson, WritesNumbersAsAPersonDoes) {
  const report::Column values =
      report::column({0.1 + 0.2, 7.599999999999999e-05, 1.0 / 3, 1e300, -0.5});
  const std::string text = report::panels_json(
      std::vector{Panel{.title = "", .series = {{.colour = "ink", .x = ramp(5), .y = values}}}});
  EXPECT_THAT(text, HasSubstr("[0.3,7.6e-05,0.333333,1e+300,-0.5]"));
}

// A report of any length stays below ten megabytes: rows are bounded, and with them the numbers.
TEST(PanelsJson, IsBoundedAndKeepsPeaks) {
  constexpr std::size_t rows = 400'000;
  std::vector<double> flat(rows, 1);
  flat[234'567] = 9;
  const report::Column time = ramp(rows);
  Panel panel{.title = "long"};
  panel.series.push_back({.colour = "ink", .x = time, .y = report::column(flat)});
  for (int k = 0; k < 20; ++k) {
    panel.series.push_back(
        {.colour = "ink", .x = time, .y = report::column_of(*time, [k](double t) {
                                       return std::sin(t * (0.01 + k));
                                     })});
  }
  const std::string text = report::panels_json(std::vector{panel});
  EXPECT_LT(text.size(), 4'000'000U);
  const nlohmann::json json = nlohmann::json::parse(text);
  std::size_t numbers = 0;
  for (const auto& column : json["columns"]) {
    numbers += column.size();
  }
  EXPECT_LE(numbers, 300'000U);
  EXPECT_GE(numbers, 80'000U);
  EXPECT_THAT(json["columns"][1].get<std::vector<double>>(), ::testing::Contains(9));
}

TEST(Panels, APageHasDataOnlyWhereSomethingDrawsThem) {
  const std::string html = report::plots_html({everything(), spans()});
  EXPECT_THAT(html, HasSubstr("data:image/svg+xml;base64,"));
  EXPECT_THAT(html, HasSubstr("&lt;/script&gt;&lt;script&gt;"));
  EXPECT_THAT(html, Not(HasSubstr("<script>alert")));
  if (report::report_script().empty()) {
    EXPECT_THAT(html, Not(HasSubstr("<script")));
  } else {
    EXPECT_THAT(html, HasSubstr("<script type=\"application/json\" class=\"panels\">"));
    EXPECT_THAT(std::string(report::report_script()), Not(HasSubstr("</script")));
    EXPECT_THAT(std::string(report::report_script()), Not(HasSubstr("<!--")));
  }
}

}  // namespace
}  // namespace smaservo::test
