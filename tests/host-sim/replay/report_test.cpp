#include "host-sim/replay/report.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "host-sim/report/assets.hpp"
#include "model/files/error.hpp"
#include "tests/host-sim/replay/replays.hpp"

namespace smaservo::test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

struct Report {
  replay::ReplayOptions options;
  replay::ReplayResult result;
  std::string html;
};

/// A run with everything that a report can show, drawn once: a trace with an ugly name, a bad row,
/// all observers, settings.
const Report& report() {
  static const Report made = [] {
    const TemporaryFolder folder;
    std::vector<std::string> lines = first_lines("200MPa.csv", 1500);
    lines.insert(lines.begin() + 3, "0.0201,0.1,<script>,0.9,0.04");
    Report r;
    r.options = replay_options(folder.write("<b>&\".csv", joined(lines)), "b");
    r.options.trace_options.lenient = true;
    r.options.observers = {"kalman", "open-loop", "line"};
    r.options.settings = {{"observer.loss_walk", "0.0123"}};
    r.result = replay::replay(r.options);
    replay::write_report(folder / "r.html", r.options, r.result, Units::bench);
    EXPECT_EQ(folder.names().size(), 2U) << "one file and nothing beside it";
    r.html = file_text(folder / "r.html");
    return r;
  }();
  return made;
}

/// The page without the script that npm has built, which is the same in all reports.
std::string without_script(std::string html) {
  const std::string_view script = report::report_script();
  const std::size_t at = script.empty() ? std::string::npos : html.find(script);
  return at == std::string::npos ? html : html.erase(at, script.size());
}

std::string from_base64(std::string_view text) {
  constexpr std::string_view digits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes;
  unsigned bits = 0;
  int count = 0;
  for (const char c : text.substr(0, text.find('='))) {
    bits = bits << 6 | static_cast<unsigned>(digits.find(c));
    count += 6;
    if (count >= 8) {
      count -= 8;
      bytes += static_cast<char>(bits >> count & 0xffU);
    }
  }
  return bytes;
}

std::vector<std::string> pictures(const std::string& html) {
  std::vector<std::string> all;
  constexpr std::string_view mark = "data:image/svg+xml;base64,";
  for (std::size_t at = 0; (at = html.find(mark, at)) != std::string::npos;) {
    at += mark.size();
    all.push_back(from_base64(std::string_view(html).substr(at, html.find('"', at) - at)));
  }
  return all;
}

TEST(Report, IsOneHtmlDocument) {
  const std::string html = without_script(report().html);
  EXPECT_TRUE(html.starts_with("<!doctype html>"));
  EXPECT_TRUE(html.ends_with("</html>\n"));
  for (const char* tag : {"section", "table", "pre", "div", "script", "style", "h1", "h2"}) {
    const auto count = [&](const std::string& part) {
      std::size_t found = 0;
      for (std::size_t at = 0; (at = html.find(part, at)) != std::string::npos; ++at) {
        ++found;
      }
      return found;
    };
    EXPECT_EQ(count(fmt::format("<{}>", tag)) + count(fmt::format("<{} ", tag)),
              count(fmt::format("</{}>", tag)))
        << tag;
  }
}

/// Addresses of the network, without the names that XML gives to its vocabularies.
std::vector<std::string> addresses(const std::string& text) {
  std::vector<std::string> all;
  for (const char* start : {"http:", "https:", "ftp:", "=\"//", "='//", "url(//"}) {
    for (std::size_t at = 0; (at = text.find(start, at)) != std::string::npos; ++at) {
      const std::string found = text.substr(at, text.find_first_of("\"' \n)<", at + 3) - at);
      if (!found.starts_with("http://www.w3.org/")) {
        all.push_back(found);
      }
    }
  }
  return all;
}

TEST(Report, NeedsNoNetwork) {
  std::string without_pictures = without_script(report().html);
  std::size_t at = 0;
  while ((at = without_pictures.find("base64,", at)) != std::string::npos) {
    at += 7;
    without_pictures.erase(at, without_pictures.find('"', at) - at);
  }
  EXPECT_THAT(addresses(without_pictures), ElementsAre());
  EXPECT_THAT(without_pictures, Not(HasSubstr("src=\"h")));
  EXPECT_THAT(without_pictures, Not(HasSubstr("<link")));
  EXPECT_THAT(without_pictures, HasSubstr("default-src 'none'"));
}

TEST(Report, HasAllPicturesWithDataInThem) {
  const std::vector<std::string> svg = pictures(report().html);
  ASSERT_EQ(svg.size(), 8U);
  for (const std::string& picture : svg) {
    EXPECT_THAT(picture, HasSubstr("<svg"));
    EXPECT_THAT(picture, HasSubstr("</svg>"));
    EXPECT_GT(picture.size(), 30'000U) << "hundreds of points";
    std::string scripts_gone = picture;
    // The mouse's icon is data, too, and long enough to hold anything by chance.
    for (std::size_t at = 0; (at = scripts_gone.find("base64,", at)) != std::string::npos;) {
      at += 7;
      scripts_gone.erase(at, scripts_gone.find_first_of("'\"", at) - at);
    }
    EXPECT_THAT(addresses(scripts_gone), ElementsAre());
  }
}

// The script finds in the page what it draws, and what stands there is the run.
TEST(Report, HasTheDataOfItsPanels) {
  if (report::report_script().empty()) {
    GTEST_SKIP() << "built without npm";
  }
  const std::string& html = report().html;
  constexpr std::string_view begin = "<script type=\"application/json\" class=\"panels\">";
  const std::size_t at = html.find(begin) + begin.size();
  const auto json = nlohmann::json::parse(html.substr(at, html.find("</script>", at) - at));
  ASSERT_EQ(json["panels"].size(), 8U);
  const auto& error = json["panels"][1]["series"][0];
  const auto values = json["columns"][error["y"].get<std::size_t>()].get<std::vector<double>>();
  EXPECT_EQ(values.size(), 1500U);
  EXPECT_NEAR(std::abs(*std::ranges::max_element(values, {}, [](double e) { return std::abs(e); })),
              report().result.observers[0].error.maximum(), 1e-3);
}

TEST(Report, SaysTheNumbers) {
  const Report& r = report();
  for (const replay::ObserverResult& observer : r.result.observers) {
    EXPECT_THAT(r.html, HasSubstr(observer.name));
    EXPECT_THAT(r.html, HasSubstr(fmt::format("<td>{:.2f}</td><td>{:.2f}</td><td>{:.2f}</td>",
                                              observer.error.mean(), observer.error.quantile(0.95),
                                              observer.error.maximum())));
  }
  EXPECT_THAT(r.html, HasSubstr("1500 rows"));
  EXPECT_THAT(r.html, HasSubstr("1 bad rows skipped"));
  EXPECT_THAT(r.html, HasSubstr("length_m = 0.0991"));
  EXPECT_THAT(r.html, HasSubstr("observer.loss_walk = 0.0123  # set"));
}

TEST(Report, EscapesWhatItDidNotWriteItself) {
  const std::string html = without_script(report().html);
  EXPECT_THAT(html, HasSubstr("&lt;b&gt;&amp;&quot;.csv</title>"));
  EXPECT_THAT(html, HasSubstr("&lt;script&gt;"));
  EXPECT_THAT(html, Not(HasSubstr("<b>")));
}

TEST(Report, SaysWhenThereIsNoReferenceAndNoTime) {
  const TemporaryFolder folder;
  std::string text = "temperature_degC,stress_MPa\n";
  for (int i = 0; i < 200; ++i) {
    text += std::to_string(i < 100 ? 25 + i : 225 - i) + ",150\n";
  }
  const replay::ReplayOptions options = replay_options(folder.write("t.csv", text), "b");
  const replay::ReplayResult result = replay::replay(options);
  replay::write_report(folder / "r.html", options, result, Units::bench);
  const std::string html = file_text(folder / "r.html");
  EXPECT_THAT(html, HasSubstr("The trace has no reference"));
  EXPECT_EQ(pictures(html).size(), 7U);
  EXPECT_THAT(replay::summary(options, result), HasSubstr("no strain_ref or displacement"));
  EXPECT_FALSE(nlohmann::json::parse(replay::summary_json(options, result)).contains("error"));
}

TEST(Report, ASingleRowIsEnough) {
  const TemporaryFolder folder;
  const replay::ReplayOptions options = replay_options(
      folder.write("t.csv", "time_s,current_A,voltage_V,load_N\n0,0.05,1.2,0.9\n"), "b");
  replay::write_report(folder / "r.html", options, replay::replay(options), Units::bench);
  EXPECT_EQ(pictures(file_text(folder / "r.html")).size(), 7U);
}

TEST(Report, NothingIsWrittenWhereItCannotBe) {
  const TemporaryFolder folder;
  const Report& r = report();
  EXPECT_THROW(replay::write_report(folder / "missing/r.html", r.options, r.result, Units::bench),
               files::UserError);
  EXPECT_TRUE(folder.names().empty());
}

}  // namespace
}  // namespace smaservo::test
