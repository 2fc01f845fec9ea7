#include "host-sim/report/panel.hpp"

#include <cmath>
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

/// A panel with a unit on each axis, whose columns are shared.
Panel loop(const report::Column& time, const report::Column& temperature,
           const report::Column& stress) {
  Panel panel{.x = {.label = "temperature in °C", .min = 20, .max = 100, .ticks = {{50, "half"}}},
              .y = {.label = "stress in MPa", .min = 0},
              .right = {.label = "share in %"},
              .follows = "time"};
  panel.series = {{.colour = "ink", .x = temperature, .y = stress, .low = stress, .at = time},
                  {.colour = "ink", .x = temperature, .y = time, .right = true},
                  {.colour = "fault", .kind = Kind::spans, .x = temperature, .y = temperature}};
  panel.rules = {{150, "", "ink"}, {90, "", "ink", true}};
  panel.notes = {{25, 100, "note"}};
  return panel;
}

TEST(Panels, AreInTheChosenUnits) {
  const report::Column time = report::column({0, 1});
  const report::Column temperature = report::column({20, nan});
  const report::Column stress = report::column({150, 200});
  const Panel linked{.x = {.label = "time in s"},
                     .y = {.label = "temperature in °C"},
                     .link = "time",
                     .series = {{.x = time, .y = temperature}}};
  const std::vector<Panel> all =
      report::in_units({linked, loop(time, temperature, stress)}, Units::si);
  const Panel& panel = all[1];
  EXPECT_EQ(all[0].y.label, "temperature in K");
  EXPECT_EQ(panel.x.label, "temperature in K");
  EXPECT_EQ(panel.y.label, "stress in Pa");
  EXPECT_EQ(panel.right.label, "share in %");
  EXPECT_EQ(panel.x.min, 293.15);
  EXPECT_EQ(panel.x.max, 373.15);
  EXPECT_EQ(panel.x.ticks[0].first, 323.15);
  EXPECT_EQ(panel.y.min, 0);
  EXPECT_TRUE(std::isnan(panel.y.max));
  EXPECT_EQ(panel.rules[0].at, 150e6);
  EXPECT_EQ(panel.rules[1].at, 363.15);
  EXPECT_EQ(panel.notes[0].x, 298.15);
  EXPECT_EQ(panel.notes[0].y, 100e6);
  EXPECT_EQ(panel.series[0].x->front(), 293.15);
  EXPECT_TRUE(std::isnan(panel.series[0].x->back()));
  EXPECT_EQ(panel.series[0].y->front(), 150e6);
  EXPECT_EQ(panel.series[0].at, time);
  EXPECT_EQ(panel.series[1].y, time) << "% stays";
  EXPECT_EQ(panel.series[2].y, panel.series[2].x) << "spans lie along x";
  EXPECT_EQ(panel.series[0].low, panel.series[0].y) << "shared columns stay shared";
  EXPECT_EQ(all[0].series[0].y, panel.series[0].x) << "also between panels";
}

// What is in SI comes on the bench; there and back is the same; what has no other unit stays.
TEST(Panels, BenchAndSiAreInverse) {
  const auto labelled = [](const char* label) {
    return Panel{.x = {.label = "time in s"},
                 .y = {.label = label, .min = 2.5},
                 .series = {{.x = ramp(5), .y = ramp(5)}}};
  };
  struct Labels {
    const char *bench, *si;
  };
  for (const auto& [bench, si] :
       {Labels{"current in mA", "current in A"}, Labels{"power in mW", "power in W"},
        Labels{"contraction in µm", "contraction in m"}, Labels{"stress in MPa", "stress in Pa"},
        Labels{"temperature in °C", "temperature in K"}}) {
    const Panel given = labelled(bench);
    const Panel there = report::in_units({given}, Units::si).front();
    const Panel back = report::in_units({there}, Units::bench).front();
    EXPECT_EQ(there.y.label, si);
    EXPECT_EQ(back.y.label, bench);
    EXPECT_EQ(report::in_units({given}, Units::bench).front().series[0].y, given.series[0].y);
    EXPECT_NE(there.series[0].y->at(3), 3);
    EXPECT_NEAR(back.series[0].y->at(3), 3, 1e-9);
    EXPECT_NEAR(back.y.min, 2.5, 1e-9);
  }
  for (const char* const label : {"time in s", "strain in %", "true less reference in K",
                                  "resistance in Ω", "temperature", "length in mm"}) {
    const Panel panel = report::in_units({labelled(label)}, Units::bench).front();
    EXPECT_EQ(panel.y.label, label);
    EXPECT_EQ(panel.y.min, 2.5);
  }
}

TEST(Panels, APageIsInTheChosenUnits) {
  if (report::report_script().empty()) {
    GTEST_SKIP() << "built without the page";
  }
  const Panel panel =
      loop(report::column({0, 1}), report::column({20, 21}), report::column({1, 2}));
  const std::string si = report::plots_html({panel}, Units::si);
  EXPECT_THAT(si, HasSubstr("stress in Pa"));
  EXPECT_THAT(si, HasSubstr("293.15"));
  EXPECT_THAT(si, Not(HasSubstr("MPa")));
  EXPECT_THAT(report::plots_html({panel}, Units::bench), HasSubstr("stress in MPa"));
}

TEST(Panels, APageHasDataOnlyWhereSomethingDrawsThem) {
  const std::string html = report::plots_html({everything(), spans()}, Units::bench);
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
