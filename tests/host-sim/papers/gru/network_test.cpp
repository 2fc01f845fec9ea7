#include "host-sim/papers/gru/network.hpp"

#include <cmath>
#include <filesystem>
#include <functional>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <limits>
#include <sys/stat.h>

#include "model/files/error.hpp"
#include "tests/hal/replay/temporary_folder.hpp"
#include "tests/host-sim/papers/gru/small_network.hpp"
#include "tests/places.hpp"

namespace smaservo::test {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;
using Json = nlohmann::ordered_json;

gru::Network read(const Json& json) {
  return gru::parse_network("gru.json", json.dump());
}

std::string refusal_of(const std::string& text) {
  try {
    gru::parse_network("gru.json", text);
  } catch (const files::ConfigError& error) {
    return error.what();
  }
  return "";
}

std::string refusal(const std::function<void(Json&)>& change) {
  Json json = small_network();
  change(json);
  return refusal_of(json.dump());
}

TEST(GruNetwork, OfOneUnitIsWhatCanBeComputedByHand) {
  const gru::Network network = read(small_network());
  EXPECT_EQ(network.hidden(), 1);
  EXPECT_EQ(network.parameters(), 3 * (3 + 1 + 1) + 2);
  EXPECT_EQ(network.runs[0].name, "a.csv");
  gru::Cell cell(network);
  const double first = 0.5 * std::tanh(1.0);
  EXPECT_NEAR(cell.next({1, 7, 150}), 0.04 * first, 1e-15);
  EXPECT_NEAR(cell.next({1, 7, 150}), 0.04 * (0.5 * first + 0.5 * std::tanh(1 + first)), 1e-15);
}

TEST(GruNetwork, ScalesGatesAndBiasesAreWhereTheyBelong) {
  Json json = small_network();
  json["inputs"][1]["mean"] = 2;
  json["inputs"][1]["scale"] = 4;
  json["inputs"][2]["scale"] = 100;
  json["output"]["mean"] = 30;
  json["output"]["scale"] = 10;
  json["weights"]["reset_input"][0] = {0.5, 0.0, 1.0};
  json["weights"]["update_state"][0][0] = -3;
  json["weights"]["update_bias"][0] = 0.25;
  json["weights"]["candidate_input"][0] = {1.0, -2.0, 0.0};
  json["weights"]["candidate_bias"][0] = 0.125;
  json["weights"]["output"][0] = -4;
  json["weights"]["output_bias"] = 0.75;
  const auto sigmoid = [](double x) { return 1 / (1 + std::exp(-x)); };
  const gru::Network network = read(json);
  gru::Cell cell(network);
  double state = 0;
  for (const double power_W : {3.0, 1.0, 2.5}) {
    const double ratio = 0.9, stress = 1.5;  // of 100 MPa
    const double reset = sigmoid(0.5 * ratio + stress);
    const double update = sigmoid(-3 * state + 0.25);
    const double candidate = std::tanh(ratio - 2 * (power_W - 2) / 4 + 0.125 + 2 * (reset * state));
    state = update * state + (1 - update) * candidate;
    const double percent = 30 + 10 * (-4 * state + 0.75);
    EXPECT_NEAR(cell.next({ratio, power_W, 150}), percent / 100 * 0.04, 1e-15);
  }
}

TEST(GruNetwork, TheGreatestWeightsStillGiveANumber) {
  Json json = small_network();
  for (auto& weight : json["weights"]["candidate_input"][0]) {
    weight = 1e6;
  }
  json["weights"]["reset_input"][0] = {-1e6, 1e6, 1e6};
  json["weights"]["candidate_state"][0][0] = -1e6;
  json["weights"]["output"][0] = 1e6;
  json["inputs"][0]["scale"] = 1e-9;
  json["output"]["scale"] = 1e9;
  const gru::Network network = read(json);
  gru::Cell cell(network);
  for (const double x : {1e12, -1e12, 0.0}) {
    EXPECT_TRUE(std::isfinite(cell.next({x, x, x})));
  }
}

TEST(GruNetwork, TheShippedOneIsRead) {
  const gru::Network network = gru::load_network(
      (std::filesystem::path(source_folder()) / "host-sim/papers/gru/traces.json").string());
  EXPECT_EQ(network.hidden(), 32);
  EXPECT_EQ(network.parameters(), 3489);
  ASSERT_EQ(network.runs.size(), 4U);
  EXPECT_EQ(network.runs[2].name, "150MPa.csv");
  EXPECT_EQ(network.runs[2].rows, 20000U);
}

TEST(GruNetwork, WhatIsNoNetworkIsRefused) {
  for (const char* text :
       {"", "{", "nonsense", "{\"format\": \"smaservo-gru\"", "\xff\xfe", "{}}"}) {
    EXPECT_THAT(refusal_of(text), StartsWith("gru.json: is no JSON: ")) << text;
  }
  EXPECT_EQ(refusal_of("[1, 2]"), "gru.json: [1,2]: must be an object, {\"key\": value, ...}");
  EXPECT_EQ(refusal_of("{}"), "gru.json: format: is missing");
  EXPECT_THAT(refusal_of(std::string(100000, '[')), HasSubstr("is nested deeper than 4 levels"));
  EXPECT_EQ(refusal_of("{\"format\": 1, \"format\": 2}"), "gru.json: format: is given twice");
}

TEST(GruNetwork, EachWrongValueIsNamedWithWhatIsAllowed) {
  struct Wrong {
    std::function<void(Json&)> change;
    const char* said;
  };
  const Wrong all[] = {
      {[](Json& j) { j["format"] = "onnx"; }, "format = \"onnx\": must be \"smaservo-gru\""},
      {[](Json& j) { j["version"] = 2; }, "version = 2: must be 1"},
      {[](Json& j) { j["hidden"] = 0; }, "hidden = 0: must be a whole number from 1 to 256"},
      {[](Json& j) { j["hidden"] = 1025; }, "hidden = 1025: must be a whole number from 1 to 256"},
      {[](Json& j) { j["hidden"] = -1; }, "hidden = -1: must be a whole number"},
      {[](Json& j) { j["hidden"] = 1.5; }, "hidden = 1.5: must be a whole number"},
      {[](Json& j) { j["step_s"] = 1e-9; }, "step_s = 1e-09: must be a number from 0.001 to 1"},
      {[](Json& j) { j["step_s"] = nullptr; }, "step_s = null: must be a number from"},
      {[](Json& j) { j["nominal_stroke"] = 4; }, "nominal_stroke = 4: must be a number from"},
      {[](Json& j) { j.erase("seed"); }, "seed: is missing"},
      {[](Json& j) { j["epochs"] = "many"; }, "epochs = \"many\": must be a whole number from"},
      {[](Json& j) { j["epoch"] = 1; },
       "epoch: unknown key (did you mean epochs?); allowed: format"},
      {[](Json& j) { j["runs"] = Json::array(); }, "runs = []: must be a list of 1 to 1000"},
      {[](Json& j) { j["runs"][0].erase("rows"); }, "runs[0].rows: is missing"},
      {[](Json& j) { j["runs"][0]["name"] = ""; }, "runs[0].name = \"\": must be a text of 1 to"},
      {[](Json& j) { j["runs"][0] = 7; }, "runs[0] = 7: must be an object"},
      {[](Json& j) { j["inputs"].erase(2); }, "must be a list of 3 elements"},
      {[](Json& j) { j["inputs"][1]["name"] = "stress"; },
       "inputs[1].name = \"stress\": must be \"power\""},
      {[](Json& j) { j["inputs"][2]["unit"] = "Pa"; }, "inputs[2].unit = \"Pa\": must be \"MPa\""},
      {[](Json& j) { j["inputs"][0]["scale"] = 0; }, "inputs[0].scale = 0: must be a number from"},
      {[](Json& j) { j["output"]["colour"] = "red"; }, "output.colour: unknown key; allowed: name"},
      {[](Json& j) { j["output"] = Json::array(); }, "output = []: must be an object"},
      {[](Json& j) { j["weights"].erase("output"); }, "weights.output: is missing"},
      {[](Json& j) { j["weights"]["reset_bias"] = {1.0, 2.0}; },
       "weights.reset_bias = [1.0,2.0]: must be a list of 1 numbers, has 2"},
      {[](Json& j) { j["weights"]["reset_bias"] = 1; },
       "weights.reset_bias = 1: must be a list of 1 numbers"},
      {[](Json& j) { j["weights"]["update_input"][0] = {1.0, 2.0}; },
       "weights.update_input[0] = [1.0,2.0]: must be a list of 3 numbers, has 2"},
      {[](Json& j) { j["weights"]["update_state"].push_back({1.0}); },
       "weights.update_state = [[0.0],[1.0]]: must be a list of 1 elements"},
      {[](Json& j) { j["weights"]["candidate_input"][0][1] = nullptr; },
       "weights.candidate_input[0][1] = null: must be a number from -1000000 to 1000000"},
      {[](Json& j) { j["weights"]["output"][0] = 1e7; }, "weights.output[0] = 10000000.0: must be"},
      {[](Json& j) { j["weights"]["output_bias"] = "0"; }, "weights.output_bias = \"0\": must be"},
      {[](Json& j) { j["weights"]["\x1b[31m"] = 1; }, "weights.\\x1B[31m: unknown key"},
  };
  for (const Wrong& wrong : all) {
    const std::string said = refusal(wrong.change);
    EXPECT_THAT(said, StartsWith("gru.json: "));
    EXPECT_THAT(said, HasSubstr(wrong.said));
    EXPECT_LT(said.size(), 400U);
  }
  // JSON has no infinite numbers; this is how one gets there.
  std::string text = small_network().dump();
  text.replace(text.find("[1.0,0.0,0.0]"), 4, "[1e999");
  EXPECT_THAT(refusal_of(text), StartsWith("gru.json: "));
}

TEST(GruNetwork, EveryPartOfAFileAndEveryWrongByteIsReadOrRefused) {
  const std::string text = small_network().dump();
  for (std::size_t size = 0; size < text.size(); ++size) {
    EXPECT_NE(refusal_of(text.substr(0, size)), "") << size;
  }
  for (std::size_t i = 0; i < text.size(); ++i) {
    std::string wrong = text;
    for (const char c : {'\0', '9', '[', '"', '\xff'}) {
      wrong[i] = c;
      const std::string said = refusal_of(wrong);
      EXPECT_TRUE(said.empty() || said.starts_with("gru.json: ")) << said;
    }
  }
}

TEST(GruNetwork, AFileThatCannotBeReadIsNamed) {
  const TemporaryFolder folder;
  const auto said = [](const std::string& path) -> std::string {
    try {
      gru::load_network(path);
    } catch (const files::ConfigError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(said(folder / "none.json"), HasSubstr("none.json: cannot be read: No such file"));
  EXPECT_THAT(said(folder.path()), HasSubstr(": cannot be read: it is a folder"));
  const std::string large = folder.write("large.json", "{}");
  std::filesystem::resize_file(large, 1ULL << 40U);  // it takes no room on the disk
  EXPECT_EQ(said(large), large + ": must be a file of at most 8 MiB");
  EXPECT_EQ(said("/dev/zero"), "/dev/zero: must be a file of at most 8 MiB");
  const std::string pipe = folder / "pipe";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_EQ(said(pipe), pipe + ": must be a file of at most 8 MiB") << "nobody writes into it";
}

TEST(GruNetwork, ARunIsNamedByItsStrain) {
  EXPECT_EQ(gru::checksum_of({}), "6c62272e07bb014262b821756295c58d") << "FNV-1a of nothing";
  EXPECT_NE(gru::checksum_of({0.04, 0.03}), gru::checksum_of({0.03, 0.04}));
  EXPECT_NE(gru::checksum_of({0.04}), gru::checksum_of({std::nextafter(0.04, 1)}));
}

}  // namespace
}  // namespace smaservo::test
