// host-sim identify as its user meets it, and what its files say.

#include <algorithm>
#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <sstream>

#include "host-sim/identify/fitted_wire.hpp"
#include "host-sim/identify/report.hpp"
#include "model/files/wire/wire_fields.hpp"
#include "tests/host-sim/program.hpp"
#include "tests/host-sim/recordings.hpp"

namespace smaservo::test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::UnorderedElementsAre;
using Texts = Program::Texts;

/// A wire whose strain runs up and down ten times while it is heated once.
std::string impossible_csv() {
  Recording r;
  for (std::size_t i = 0; i < r.strain.size(); ++i) {
    r.strain[i] = 0.04 + 0.03 * std::sin(0.6 * r.temperature_degC[i]);
  }
  return csv({{"temperature_degC", r.temperature_degC},
              {"strain_ref", r.strain},
              {"stress_MPa", std::vector<double>(r.strain.size(), 150.0)}});
}

/// The fit of bath_file() as the program does it.
identify::FitResult fitted(const std::function<bool(const identify::FitProgress&)>& proceed =
                               [](const auto&) { return true; }) {
  const TemporaryFolder folder;
  const files::WireDescription from = files::load_wire("smartflex-76um");
  const identify::Run run =
      identify::read_run(folder.write("bath.csv", bath_file()), {from.wire.geometry, {}, {}, {}});
  identify::FitOptions options;
  options.proceed = proceed;
  identify::FitResult fit = identify::fit_wire(from.wire, {run}, options);
  fit.runs.front().name = "bath.csv";
  return fit;
}

Texts identify(const Texts& more) {
  Texts arguments{"identify", "--out", "w.toml"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

TEST(Identify, WrongArgumentsEndWith2) {
  const Texts wrong[] = {{"identify"},
                         {"identify", "bath.csv"},
                         {"identify", "--out", "w.toml"},
                         identify({"--threads", "0", "bath.csv"}),
                         identify({"--observer", "kalman", "bath.csv"}),
                         identify({"--stress-MPa", "1", "--load-N", "1", "bath.csv"})};
  Program program;
  program.folder().write("bath.csv", bath_file());
  for (const Texts& arguments : wrong) {
    EXPECT_EQ(program.run(arguments).status, 2) << ::testing::PrintToString(arguments);
  }
  EXPECT_THAT(program.folder().names(), ElementsAre("bath.csv"));
}

TEST(Identify, MistakesEndWith1AndNameWhatIsWrong) {
  const std::pair<Texts, const char*> wrong[] = {
      {{"identify", "--out", "w.csv", "bath.csv"}, "--out w.csv: the name of a wire file"},
      {{"identify", "--out", "-", "bath.csv"}, "--out -: the name of a wire file"},
      {{"identify", "--out", "no/w.toml", "bath.csv"}, "no/w.toml: cannot be written"},
      {{"identify", "--out", "run.toml", "run.toml"}, "run.toml: is the same file as run.toml"},
      {{"identify", "--out", "./f.toml", "--from", "f.toml", "bath.csv"}, "./f.toml: is the same"},
      {identify({"bath.csv", "./bath.csv"}), "./bath.csv: is the same file as bath.csv"},
      {identify({"--held-out", "./bath.csv", "bath.csv"}),
       "./bath.csv: is the same file as bath.csv"},
      {identify({"--held-out", "still.csv", "bath.csv"}), "still.csv"},
      {identify({"--imposed-strain", "bath.csv"}), "--imposed-strain: none of the runs"},
      {identify({"--report", "bath.csv", "bath.csv"}), "bath.csv: is the same file as bath.csv"},
      {identify({"--report", "w.toml", "bath.csv"}), "w.toml: is the same file as w.toml"},
      {identify({"--from", "nothing", "bath.csv"}), "nothing: no such wire"},
      {identify({"--set", "observer.loss_walk=1", "bath.csv"}), "observer"},
      {identify({"--set", "wire.length_mm=0", "bath.csv"}), "wire.length_mm = 0"},
      {identify({"--stress-MPa", "-1", "bath.csv"}), "--stress-MPa -1: must be between"},
      {identify({"missing.csv"}), "missing.csv: No such file"},
      {identify({"still.csv"}), "still.csv"},
  };
  Program program;
  program.folder().write("bath.csv", bath_file());
  program.folder().write("run.toml", bath_file());
  program.folder().write("f.toml", files::to_toml(files::load_wire("smartflex-76um")));
  program.folder().write("still.csv", csv({{"temperature_degC", std::vector<double>(50, 25.0)},
                                           {"strain_ref", std::vector<double>(50, 0.04)},
                                           {"stress_MPa", std::vector<double>(50, 100.0)}}));
  for (const auto& [arguments, said] : wrong) {
    const Finished f = program.run(arguments);
    EXPECT_EQ(f.status, 1) << said;
    EXPECT_THAT(f.err, HasSubstr(said));
    EXPECT_EQ(f.out, "");
  }
  EXPECT_THAT(program.folder().names(),
              UnorderedElementsAre("bath.csv", "run.toml", "f.toml", "still.csv"));
}

TEST(Identify, AFitThatExplainsNothingLeavesTheOldFile) {
  Program program;
  program.folder().write("odd.csv", impossible_csv());
  program.folder().write("w.toml", "the old one");
  const Finished f = program.run(identify({"--report", "r.html", "odd.csv"}));
  EXPECT_EQ(f.status, 1);
  EXPECT_THAT(f.err, HasSubstr("odd.csv: the fitted model misses its strain by"));
  EXPECT_EQ(f.out, "");
  EXPECT_THAT(program.folder().names(), UnorderedElementsAre("odd.csv", "w.toml"));
  EXPECT_EQ(file_text(program.folder() / "w.toml"), "the old one");
}

TEST(Identify, WritesTheWireThatWasFitted) {
  Program program;  // NOLINT(misc-const-correctness): run() changes it
  program.folder().write("bath.csv", bath_file());
  const Finished f = program.run(identify({"--threads", "1", "bath.csv"}));
  ASSERT_EQ(f.status, 0) << f.err;
  const identify::FitResult fit = fitted();
  const std::string text = file_text(program.folder() / "w.toml");
  EXPECT_EQ(text,
            files::to_toml(identify::fitted_wire(files::load_wire("smartflex-76um"), fit, "w")));
  const files::WireDescription loaded = files::load_wire(program.folder() / "w.toml");
  EXPECT_EQ(loaded.name, "w");
  const files::Entries read = files::describe_wire(loaded.wire);
  const files::Entries expected = files::describe_wire(fit.wire);
  ASSERT_EQ(read.size(), expected.size());
  for (const auto& [slot, entry] : expected) {
    // The numbers are equal except for rounding.
    EXPECT_NEAR(read.at(slot).number, entry.number, 1e-12 * std::abs(entry.number))
        << entry.field->path;
  }
}

TEST(Identify, SourcesSayWhatIsNewAndWhatIsNot) {
  const files::WireDescription from =
      files::load_wire("smartflex-76um", {{"wire.length_mm", "120"}});
  const identify::FitResult fit = fitted();
  const files::WireDescription wire = identify::fitted_wire(from, fit, "mine");
  const std::map<std::string, std::string> sources(wire.sources.begin(), wire.sources.end());
  EXPECT_EQ(sources.at("wire.length"), "given with --set");
  EXPECT_THAT(sources.at("wire.limits.temperature"), HasSubstr("paper 000"));
  EXPECT_THAT(sources.at("wire.m2a"), HasSubstr("identified from bath.csv; "));
  EXPECT_THAT(sources.at("wire.m2a"), HasSubstr("width "));
  EXPECT_THAT(sources.at("wire.m2a"), HasSubstr("kept from smartflex-76um: "));
  EXPECT_THAT(sources.at("wire.heat"),
              HasSubstr("not determined by bath.csv, kept from smartflex-76um"));
  EXPECT_THAT(sources.at("wire.a2m"), HasSubstr("identified from bath.csv; "));
  EXPECT_FALSE(sources.contains("wire.martensite.strain")) << "measured now";
  EXPECT_TRUE(sources.contains("wire.martensite.resistivity")) << "still the paper's";
}

TEST(Identify, FiguresAreInTheUnitsOfMessages) {
  const identify::FittedParameter sum{
      {"a.temperature", "degC", 1, identify::Form::sum, 353.15, 8}, 350.65, 0.25, 0.03, true};
  EXPECT_NEAR(identify::figure(sum).value, 77.5, 1e-9);
  EXPECT_NEAR(identify::figure(sum).prior, 80, 1e-9);
  EXPECT_NEAR(identify::figure(sum).sd, 0.25, 1e-12);
  const identify::FittedParameter factor{
      {"a.modulus", "GPa", 1e9, identify::Form::factor, 30e9, 0.4}, 40e9, 0.1, 0.25, true};
  EXPECT_NEAR(identify::figure(factor).value, 40, 1e-9);
  EXPECT_NEAR(identify::figure(factor).sd, 4, 1e-9);
  EXPECT_NEAR(identify::figure(factor).prior_sd, 12, 1e-9);
  const identify::FittedParameter share{
      {"a.turning", "", 1, identify::Form::share, 0.5, 0.4}, 0.2, 0.1, 0.25, true};
  EXPECT_NEAR(identify::figure(share).sd, 0.016, 1e-12) << "the logit's slope is 1/(x (1 - x))";
  EXPECT_EQ(identify::with_deviation(74.8123, 0.12), "74.81 ± 0.12");
  EXPECT_EQ(identify::with_deviation(-12345, 600), "-12345 ± 600");
  EXPECT_EQ(identify::with_deviation(-1e-15, 6), "0.0 ± 6.0");
}

TEST(Identify, ABathWithoutResistanceDeterminesNoResistivity) {
  Program program;
  program.folder().write("bath.csv", bath_file());
  const Finished f = program.run(identify({"--json", "bath.csv"}));
  ASSERT_EQ(f.status, 0) << f.err;
  const auto json = nlohmann::json::parse(f.out);
  std::size_t determined = 0;
  for (const auto& parameter : json["parameters"]) {
    const std::string key = parameter["key"];
    const bool electrical = key.find("resistivity") != std::string::npos;
    if (electrical || key.starts_with("wire.heat.")) {
      EXPECT_FALSE(parameter["determined"]) << key;
      EXPECT_NEAR(parameter["value"].get<double>(), parameter["prior"].get<double>(),
                  1e-6 * std::abs(parameter["prior"].get<double>()))
          << key;
    }
    determined += parameter["determined"].get<bool>() ? 1U : 0U;
    if (key == "wire.m2a.width" || key == "wire.martensite.strain") {
      EXPECT_TRUE(parameter["determined"]) << key;
    }
  }
  EXPECT_GE(determined, 5U);
  EXPECT_TRUE(json["runs"][0].contains("classic_rms_percent"));
  EXPECT_FALSE(json["runs"][0].contains("resistance"));
  const Finished text = program.run(identify({"bath.csv"}));
  EXPECT_THAT(text.out, HasSubstr("not determined by these runs, kept from smartflex-76um:"));
  EXPECT_THAT(text.out, HasSubstr("wire.austenite: resistivity_ratio"));
  const std::size_t lists = text.out.find("determined by these runs:");
  ASSERT_NE(lists, std::string::npos);
  std::istringstream lines(text.out.substr(lists));
  for (std::string line; std::getline(lines, line) && !line.starts_with("strongly");) {
    EXPECT_LE(line.size(), 80U) << line;
  }
}

TEST(Identify, RunsHeldOutArePredictedAndChangeNothingOfTheFit) {
  Program program;
  program.folder().write("bath.csv", bath_file(100));
  program.folder().write("other.csv", bath_file(120));
  const Finished without = program.run(identify({"--json", "bath.csv"}));
  ASSERT_EQ(without.status, 0) << without.err;
  const std::string wire = file_text(program.folder() / "w.toml");
  const Finished with = program.run(
      identify({"--json", "--report", "r.html", "--held-out", "other.csv", "bath.csv"}));
  ASSERT_EQ(with.status, 0) << with.err;
  EXPECT_EQ(file_text(program.folder() / "w.toml"), wire);
  EXPECT_FALSE(nlohmann::json::parse(without.out).contains("runs_held_out"));
  const auto predicted = nlohmann::json::parse(with.out)["runs_held_out"];
  ASSERT_EQ(predicted.size(), 1U);
  EXPECT_EQ(predicted[0]["file"], "other.csv");
  EXPECT_GT(predicted[0]["strain"]["rms_percent"], 0.0);
  EXPECT_THAT(file_text(program.folder() / "r.html"), HasSubstr("other.csv"));
}

/// The wire file of two runs.
std::string file_by(const char* threads) {
  Program program;
  program.folder().write("a.csv", bath_file(100));
  program.folder().write("b.csv", bath_file(120));
  const Finished f = program.run(identify({"--threads", threads, "a.csv", "b.csv"}));
  EXPECT_EQ(f.status, 0) << f.err;
  return file_text(program.folder() / "w.toml");
}

TEST(Identify, SameRunsSameFile) {
  EXPECT_EQ(file_by("1"), file_by("1"));
}

TEST(Identify, ThreadsDoNotChangeTheFile) {
  const std::string one = file_by("1");
  EXPECT_EQ(file_by("2"), one);
  EXPECT_EQ(file_by("3"), one);
}

TEST(Identify, AnInterruptedFitSaysSo) {
  int steps = 0;
  const identify::FitResult fit =
      fitted([&](const identify::FitProgress&) { return ++steps < 20; });
  ASSERT_TRUE(fit.interrupted);
  const files::WireDescription wire =
      identify::fitted_wire(files::load_wire("smartflex-76um"), fit, "w");
  EXPECT_THAT(files::to_toml(wire), HasSubstr("bath.csv (interrupted before it was finished)"));
  identify::Identification all;
  all.out = "w.toml";
  all.runs.resize(1);
  all.fit = fit;
  all.classics.resize(1);
  all.held_out_runs.resize(1);
  EXPECT_THAT(identify::fit_summary(all), HasSubstr("INTERRUPTED"));
  EXPECT_THAT(identify::fit_summary(all), HasSubstr("runs held out: not predicted"));
  EXPECT_TRUE(nlohmann::json::parse(identify::fit_json(all))["interrupted"]);
}

/// The share at the beginning of each stage never falls; a stage that nobody has told would count
/// as the end.
TEST(Identify, SaysHowFarItIs) {
  std::vector<std::string> stages;
  double begin = 0;
  fitted([&](const identify::FitProgress& at) {
    EXPECT_LE(at.share, 1);
    if (stages.empty() || stages.back() != at.stage) {
      stages.push_back(at.stage);
      EXPECT_GE(at.share, begin) << at.stage;
      EXPECT_LT(at.share, 1) << at.stage;
      begin = at.share;
    }
    return true;
  });
  EXPECT_GE(stages.size(), 4U);
}

TEST(Identify, TheReportHasTheNumbersAndPicturesOfEveryRun) {
  Program program;
  program.folder().write("<b>.csv", bath_file());
  const Finished f = program.run(identify({"--report", "r.html", "<b>.csv"}));
  ASSERT_EQ(f.status, 0) << f.err;
  const std::string html = file_text(program.folder() / "r.html");
  EXPECT_TRUE(html.starts_with("<!doctype html>"));
  EXPECT_TRUE(html.ends_with("</html>\n"));
  EXPECT_THAT(html, HasSubstr("&lt;b&gt;.csv: strain over temperature"));
  EXPECT_THAT(html, HasSubstr("&lt;b&gt;.csv: what is left"));
  EXPECT_THAT(html, Not(HasSubstr("<b>")));
  EXPECT_THAT(html, HasSubstr("wire.a2m.turning"));
  EXPECT_THAT(html, HasSubstr("<td>not determined</td>"));
  std::size_t pictures = 0;
  for (std::size_t at = 0; (at = html.find("data:image/svg+xml", at)) != std::string::npos; ++at) {
    ++pictures;
  }
  EXPECT_EQ(pictures, 2U);
}

}  // namespace
}  // namespace smaservo::test
