// host-sim tune as its user meets it.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "firmware/text/settings_file.hpp"
#include "tests/host-sim/program.hpp"

namespace smaservo::test {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::UnorderedElementsAre;
using Texts = Program::Texts;

struct TuneCommand : ::testing::Test {
  Finished run(const Texts& more) {
    Texts arguments{"tune"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return program.run(arguments);
  }
  void refuses(const Texts& arguments, const char* why, int status = 1) {
    const Finished f = run(arguments);
    EXPECT_EQ(f.status, status) << f.err;
    EXPECT_THAT(f.err, HasSubstr(why));
    EXPECT_EQ(f.out, "");
    EXPECT_THAT(program.folder().names(), IsEmpty());
  }

  Program program;
};

TEST_F(TuneCommand, WritesSettingsAndReport) {
  const Finished f =
      run({"--stress-MPa", "150", "--out", "s.toml", "--report", "t.html", "--json"});
  ASSERT_EQ(f.status, 0) << f.err;
  EXPECT_EQ(f.err, "");
  EXPECT_THAT(program.folder().names(), UnorderedElementsAre("s.toml", "t.html"));
  const auto json = nlohmann::json::parse(f.out);
  // A device takes the file as it is.
  const Settings<double> settings = text::load_settings_file(program.folder() / "s.toml");
  EXPECT_EQ(json["settings"].size(), 40U);
  for (const auto& [path, value] : json["settings"].items()) {
    const std::size_t row = find_parameter(path);
    ASSERT_NE(row, no_parameter) << path;
    EXPECT_NEAR(parameters<double>[row].get(settings).real(), value.get<double>(),
                1e-5 * std::abs(value.get<double>()))
        << path;
  }
  EXPECT_FLOAT_EQ(static_cast<float>(settings.wire.geometry.diameter_m), 76e-6F);
  for (const char* loop : {"strain", "temperature", "resistance"}) {
    EXPECT_GE(json["margins"][loop]["worst"]["gain_dB"], 6);
    EXPECT_GE(json["margins"][loop]["worst"]["phase_deg"], 45);
  }
  EXPECT_FALSE(json["margins"].contains("force"));
  const std::string report = file_text(program.folder() / "t.html");
  for (const char* part : {"<h2>Proposal</h2>", "<h2>Steps by cooling</h2>",
                           "<h2>Loop of the strain: Nyquist</h2>", "<h2>Settings</h2>"}) {
    EXPECT_THAT(report, HasSubstr(part));
  }
}

TEST_F(TuneCommand, SaysTheSameEachTime) {
  const Texts spring{"--wire", "smartflex-100um", "--spring", "80,200,0.04"};
  const Finished f = run(spring);
  ASSERT_EQ(f.status, 0) << f.err;
  EXPECT_THAT(f.out, HasSubstr("\nforce.proportional_W_N "));
  EXPECT_EQ(run(spring).out, f.out);
}

TEST_F(TuneCommand, TakesAForceForItsStress) {
  // 0.68 N on 76 um.
  const auto load = nlohmann::json::parse(run({"--load-N", "0.68", "--json"}).out)["load"];
  EXPECT_NEAR(load["low_MPa"], 149.9, 0.05);
}

TEST_F(TuneCommand, RefusesWhatItCanNotMean) {
  refuses({}, "one load is needed: --load-N, --stress-MPa or --spring");
  refuses({"--load-N", "1", "--stress-MPa", "150"}, "one load is needed");
  refuses({"--stress-MPa", "100", "--spring", "50,100,0.04"}, "one load is needed");
  refuses({"--wire", "copper", "--stress-MPa", "150"}, "copper");
  refuses({"--stress-MPa", "700"}, "a load of 700 MPa: the wire bears up to 595.2 MPa");
  refuses({"--load-N", "3"}, "the wire bears up to 595.2 MPa (wire.limits.load, 2.7 N)");
  refuses({"--spring", "600,700,0.04"}, "the wire bears up to 595.2 MPa");
  refuses({"--stress-MPa", "nan"}, "--stress-MPa nan: must be between 0 and 10000");
  refuses({"--load-N", "-1"}, "--load-N -1: must be between 0 and 100000");
  refuses({"--stress-MPa", "150", "--ambient-degC", "nan"}, "--ambient-degC nan");
  refuses({"--stress-MPa", "150", "--current-A", "inf"}, "--current-A inf");
  refuses({"--stress-MPa", "150", "--current-A", "0.05"}, "must be at least the");
  refuses({"--spring", "100,50,0.04"}, "HIGH must be above LOW");
  refuses({"--spring", "50,100,0"}, "--spring STROKE 0: must be between");
  refuses({"--spring", "50,100"}, "--spring: At least 3 required", 2);
  refuses({"--stress-MPa", "10", "--ambient-degC", "70"}, "use colder air or another load");
  refuses({"--stress-MPa", "150", "--out", "a", "--report", "a"}, "is the same file");
}

TEST_F(TuneCommand, NamesAWireFileAsTheSettingsFindIt) {
  program.folder().write("w.toml", "name = \"w\"\nbased_on = \"smartflex-76um\"\n");
  const Finished f = run({"--wire", "w.toml", "--stress-MPa", "150", "--out", "s.toml"});
  ASSERT_EQ(f.status, 0) << f.err;
  EXPECT_NO_THROW(text::load_settings_file(program.folder() / "s.toml"));
}

TEST_F(TuneCommand, LeavesAWireFileAlone) {
  program.folder().write("w.toml", "name = \"w\"\nbased_on = \"smartflex-76um\"\n");
  const Finished f = run({"--wire", "w.toml", "--stress-MPa", "150", "--out", "./w.toml"});
  EXPECT_EQ(f.status, 1);
  EXPECT_THAT(file_text(program.folder() / "w.toml"), HasSubstr("based_on"));
}

}  // namespace
}  // namespace smaservo::test
