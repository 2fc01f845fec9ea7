// What clients ask, and what they get.

#include <fmt/format.h>
#include <future>
#include <set>

#include "firmware/text/canopen/objects.hpp"
#include "hal/recording/mcap/rows_reader.hpp"
#include "host-sim/choose/output.hpp"
#include "host-sim/page/servos/messages/tables.hpp"
#include "model/units.hpp"
#include "tests/host-sim/page/base64.hpp"
#include "tests/host-sim/page/servos/page_servos.hpp"

namespace smaservo::page {
namespace {

using test::from_base64;

/// The rows of an MCAP file.
std::string csv_of(const std::string& mcap) {
  std::size_t at = 0;
  hal::mcap::CsvOfRows rows([&](char* to, std::size_t size) {
    const std::size_t part = mcap.copy(to, size, at);
    at += part;
    return part;
  });
  std::string csv(std::size_t{1} << 20U, '\0');
  std::size_t length = 0;
  while (const std::size_t got = rows.read(csv.data() + length, csv.size() - length)) {
    length += got;
  }
  csv.resize(length);
  return csv;
}

/// What Foxglove refuses in a schema; "" where it takes it. Its parseJsonSchema() knows one type
/// for each member, and asks each object for its members.
std::string refused_by_foxglove(const json& schema) {
  static const std::set<json> simple{"boolean", "string", "number", "integer"};
  if (schema.value("type", json()) != "object") {
    return "no object: " + schema.dump();
  }
  if (!schema.contains("properties") || !schema["properties"].is_object()) {
    return "no members: " + schema.dump();
  }
  for (const auto& [name, member] : schema["properties"].items()) {
    const bool is_list = member.value("type", json()) == "array";
    const json item = is_list ? member.value("items", json::object()) : member;
    const json type = item.value("type", json());
    if (simple.contains(type)) {
      continue;
    }
    if (type != "object") {
      return name + ": " + member.dump();
    }
    if (const std::string why = refused_by_foxglove(item); !why.empty()) {
      return why;
    }
  }
  return "";
}

TEST_F(PageServos, SetsAreTakenAsAWholeOrRefusedWithTheReason) {
  const auto refused = [&](const std::vector<NamedValue>& values) {
    const auto before = bench.bus.servo(0).servo().settings();
    const std::string why = bench.set(1, values);
    EXPECT_TRUE(same_settings(before, bench.bus.servo(0).servo().settings())) << why;
    return why;
  };
  EXPECT_THAT(refused({{"node5.limits.current_A", "99"}}), HasSubstr("must be 0.001 to 20 A"));
  ASSERT_EQ(bench.in_force.size(), 1U);
  EXPECT_EQ(bench.in_force[0].value, "0.4");
  EXPECT_THAT(refused({{"node5.limits.current_A", "0.55"}, {"node5.trips.current_A", "0.3"}}),
              HasSubstr("contradicts"));
  EXPECT_THAT(refused({{"node5.limits.current_A", "null"}}), HasSubstr("must be a number"));
  EXPECT_THAT(refused({{"node5.limits.current_A", "1e999"}}), HasSubstr("is no JSON"));
  EXPECT_THAT(refused({{"node5.limits.current_A", "1e300"}}), HasSubstr("refused"));
  EXPECT_THAT(refused({{"node5.limits.current_mA", "3"}}), HasSubstr("limits.current_A"));
  EXPECT_THAT(refused({{"node5.limits.curent_A", "3"}}), HasSubstr("did you mean"));
  EXPECT_THAT(refused({{"node7.limits.current_A", "0.3"}}), HasSubstr("node 7: no such servo"));
  EXPECT_THAT(refused({{"node500.limits.current_A", "0.3"}}), HasSubstr("must be nodeN."));
  EXPECT_THAT(refused({{"node5.safe.state", "\"sideways\""}}), HasSubstr("must be"));
  EXPECT_THAT(refused({{"node5.identity.serial_number", "1.5"}}), HasSubstr("whole number"));
  EXPECT_THAT(refused({{"node5.strain.proportional_W", "1"}, {"node6.strain.proportional_W", "1"}}),
              HasSubstr("one servo"));
  EXPECT_THAT(refused({}), HasSubstr("no parameters"));
}

TEST_F(PageServos, RequestsAreCheckedBeforeAnythingMoves) {
  const auto refused = [&](const char* service, const char* request) {
    const BridgeBench::Got got = bench.call(1, service, request);
    EXPECT_TRUE(got.done && !got.ok) << service << request << got.text;
    EXPECT_EQ(bench.bus.all_flowing_A(), 0);
    return got.text;
  };
  EXPECT_THAT(refused("enable", "[]"), HasSubstr("JSON object"));
  EXPECT_THAT(refused("enable", "{"), HasSubstr("JSON object"));
  EXPECT_THAT(refused("enable", "{}"), HasSubstr("node is missing"));
  EXPECT_THAT(refused("enable", R"({"node":0})"), HasSubstr("from 1 to 127"));
  EXPECT_THAT(refused("enable", R"({"node":5.5})"), HasSubstr("whole"));
  EXPECT_THAT(refused("enable", R"({"node":6})"), HasSubstr("there are: 5"));
  EXPECT_THAT(refused("mode", R"({"node":5,"mode":2})"), HasSubstr("1 (profile position)"));
  EXPECT_THAT(refused("target", R"({"node":5,"value":null})"), HasSubstr("number"));
  EXPECT_THAT(refused("target", R"({"node":5,"value":1})"), HasSubstr("set a mode first"));
  EXPECT_THAT(refused("step", R"({"node":5,"amplitude_um":0,"seconds":1})"), HasSubstr("not be 0"));
  EXPECT_THAT(refused("step", R"({"node":5,"amplitude_um":9,"seconds":1e9})"), HasSubstr("600"));
  EXPECT_THAT(refused("try", R"({"node":5,"values":{},"seconds":2})"), HasSubstr("NAME"));
  EXPECT_THAT(refused("record", R"({"node":5,"signals":["warmth"],"seconds":1})"),
              HasSubstr("no such signal"));
  EXPECT_THAT(refused("history", R"({"node":5,"seconds":10,"points":1})"), HasSubstr("points"));
  EXPECT_THAT(refused("explain", R"({"fault":"wire_opened"})"), HasSubstr("wire_open"));
  EXPECT_THAT(refused("diff", R"({"node":5,"toml":"wire = \"/etc/passwd.toml\""})"),
              HasSubstr("not a file"));
  EXPECT_THAT(refused("export", R"({"recording":3,"as":"csv"})"), HasSubstr("not kept"));
  EXPECT_THAT(refused("export", R"({"recording":[],"as":"csv"})"), HasSubstr("must be what"));
  EXPECT_THAT(refused("export", R"({"recording":3,"as":"xls"})"), HasSubstr("must be csv or mcap"));
  EXPECT_THAT(refused("choose", R"({"force_N":5,"time_s":1})"), HasSubstr("stroke_m is missing"));
  EXPECT_THAT(refused("choose", R"({"force_N":"5","stroke_m":1,"time_s":1})"),
              HasSubstr("force_N = \"5\": must be a number"));
  EXPECT_THAT(refused("choose", R"({"force_N":5,"stroke_m":1,"time_s":1,"spring_N":1})"),
              HasSubstr("spring_N_m: one needs the other"));
  EXPECT_THAT(refused("choose", R"({"force_N":5,"stroke_m":1,"time_s":1,"life":"eternal"})"),
              HasSubstr("life = eternal"));
  EXPECT_THAT(refused("choose", R"({"force_N":5,"stroke_m":1,"time_s":1,"parallel":1.5})"),
              HasSubstr("whole"));
  EXPECT_THAT(refused("choose", R"({"force_N":5,"stroke_m":1,"time_s":1,"one_way":1})"),
              HasSubstr("true or false"));
  EXPECT_EQ(bench.id_of("nonsense"), 0U);
  EXPECT_THAT(refused("nonsense", "{}"), HasSubstr("no such service"));
}

TEST_F(PageServos, ChoosesAWireWithoutTheBus) {
  const auto chosen = [&](const char* request) {
    std::promise<Answer> answered;
    bench.bridge.call({.client = 1, .read_only = true}, bench.id_of("choose"), request,
                      [&](const Answer& answer) { answered.set_value(answer); });
    return answered.get_future().get();
  };
  const Answer good = chosen(R"({"force_N":5,"stroke_m":0.004,"time_s":0.5,"life":"long"})");
  ASSERT_TRUE(good.ok) << good.text;
  const choose::Task task{.force_N = 5,
                          .stroke_m = 0.004,
                          .time_s = 0.5,
                          .length_m = {},
                          .spring = {},
                          .supply_V = {},
                          .ambient_K = room_K};
  EXPECT_EQ(json::parse(good.text), json(choose::json(choose::choose_wires(task))));
  const Answer bad = chosen(R"({"force_N":5,"stroke_m":-1,"time_s":0.5})");
  EXPECT_FALSE(bad.ok);
  EXPECT_THAT(bad.text, HasSubstr("stroke_mm = -1000: must be between"));
}

TEST_F(PageServos, StepsAndRecordsAndExports) {
  const BridgeBench::Got step =
      bench.call(1, "step", R"({"node":5,"amplitude_um":600,"seconds":1})");
  ASSERT_TRUE(step.ok) << step.text;
  const json answer = step.json();
  EXPECT_LT(answer["figures"]["rise_s"].get<double>(), 0.5);
  EXPECT_GT(answer["figures"]["peak_K"].get<double>(), 320);
  EXPECT_TRUE(answer["gains"].contains("strain.proportional_W"));
  EXPECT_EQ(flowing_A(), 0) << "it was off before";
  const BridgeBench::Got file =
      bench.call(9, "export", json({{"recording", answer["recording"]}, {"as", "csv"}}).dump());
  EXPECT_EQ(file.json()["name"], "recording.csv");
  EXPECT_THAT(file.json()["base64"].get<std::string>(), testing::StartsWith("dGltZV9z"));
  const std::string by_id =
      fmt::format(R"({{"recording":{},"as":"csv"}})", answer["recording"]["id"].get<int>());
  // What the bridge keeps of a step has its gains as well, the same in each row.
  const std::string kept =
      from_base64(bench.call(9, "export", by_id).json()["base64"].get<std::string>());
  const auto lines = [](const std::string& text) {
    std::vector<std::string> all;
    std::istringstream in(text);
    for (std::string line; std::getline(in, line);) {
      all.push_back(line);
    }
    return all;
  };
  const std::vector<std::string> plain =
      lines(from_base64(file.json()["base64"].get<std::string>()));
  const std::vector<std::string> whole = lines(kept);
  ASSERT_EQ(whole.size(), plain.size());
  std::string names;
  std::string values;
  for (const auto& [name, value] : answer["gains"].items()) {
    if (value.is_number()) {
      names += "," + name;
      values += fmt::format(",{}", value.get<float>());
    }
  }
  EXPECT_THAT(names, HasSubstr(",strain.proportional_W,"));
  for (std::size_t i = 0; i < whole.size(); ++i) {
    EXPECT_EQ(whole[i], plain[i] + (i == 0 ? names : values));
  }
  // The other format has the same rows.
  const std::string as_mcap =
      fmt::format(R"({{"recording":{},"as":"mcap"}})", answer["recording"]["id"].get<int>());
  const json mcap = bench.call(9, "export", as_mcap).json();
  EXPECT_EQ(mcap["name"], "recording.mcap");
  EXPECT_EQ(csv_of(from_base64(mcap["base64"].get<std::string>())), kept);
  // Others go on while a recording waits for its trigger.
  const auto recorded = bench.ask(
      2, "record",
      R"({"node":5,"signals":["wire_temperature_K","drive_current_A"],"seconds":0.5,"before_s":0.1,
          "trigger":"wire_temperature_K>310"})");
  const auto stage = [&] {
    const json recordings = bench.told.of(1)["recordings"];
    return recordings.empty() ? "none" : recordings.at(0)["stage"].get<std::string>();
  };
  bench.run(0.07);
  EXPECT_EQ(stage(), "filling");
  bench.run(1);
  EXPECT_EQ(stage(), "waiting");
  EXPECT_FALSE(recorded->done);
  heat(1);
  bench.run(3);
  ASSERT_TRUE(recorded->ok) << recorded->text;
  EXPECT_EQ(stage(), "none");
  const json rows = recorded->json()["recording"]["rows"];
  ASSERT_EQ(rows.size(), 500U);
  EXPECT_LT(rows.front()[0].get<double>(), 310);
  EXPECT_LT(rows[99][0].get<double>(), 310);
  EXPECT_GE(rows[100][0].get<double>(), 310) << "the trigger";
  EXPECT_GT(rows.back()[0].get<double>(), 310);
}

TEST(PageDescription, OffersDegreesCelsiusForTemperaturesAndNotForDifferences) {
  std::size_t temperatures = 0;
  std::size_t differences = 0;
  const json description = described();
  for (const json& parameter : description["parameters"]) {
    const std::string name = parameter["name"];
    EXPECT_EQ(parameter.contains("units"), parameter["type"] == "number") << name;
    if (!parameter.contains("units")) {
      continue;
    }
    const json si{{"unit", parameter["unit"]}, {"factor", 1.0}, {"offset", 0.0}};
    EXPECT_EQ(parameter["units"][0], si) << name;
    bool shifted = false;
    for (const json& unit : parameter["units"]) {
      EXPECT_GT(unit["factor"].get<double>(), 0) << name;
      shifted = shifted || unit["offset"] != 0;
      // Each is a name that the settings take.
      const std::string suffix = unit["unit"];
      const std::string si_suffix = parameter["unit"];
      const std::string base =
          si_suffix.empty() ? name : name.substr(0, name.size() - si_suffix.size() - 1);
      EXPECT_NO_THROW(text::find_object(suffix.empty() ? base : base + "_" + suffix)) << name;
    }
    // A wire is not colder than 100 K, and no difference has a lower bound so large.
    const bool is_temperature = parameter["unit"] == "K" && parameter["min"].get<double>() >= 100;
    EXPECT_EQ(shifted, is_temperature) << name;
    temperatures += is_temperature ? 1U : 0U;
    differences += parameter["unit"] == "K" && !is_temperature ? 1U : 0U;
  }
  EXPECT_GT(temperatures, 10U);
  EXPECT_GT(differences, 4U);
}

TEST_F(PageServos, SettingsComeBackFromAFile) {
  const std::string toml =
      bench.call(2, "dump", R"({"node":5,"as":"toml"})").json()["text"].get<std::string>();
  const auto before = bench.bus.servo(0).servo().settings();
  ASSERT_EQ(bench.set(1, {{"node5.limits.power_W", "1.25"}}), "");
  const std::string request = json({{"node", 5}, {"toml", toml}}).dump();
  const json differences = bench.call(2, "diff", request).json()["differences"];
  ASSERT_EQ(differences.size(), 1U);
  EXPECT_EQ(differences[0]["name"], "limits.power_W");
  EXPECT_EQ(differences[0]["node"], 1.25);
  EXPECT_EQ(bench.call(1, "restore", request).json()["changed"], differences);
  EXPECT_TRUE(same_settings(before, bench.bus.servo(0).servo().settings()));
  const std::string lines =
      bench.call(2, "dump", R"({"node":5,"as":"can"})").json()["text"].get<std::string>();
  EXPECT_THAT(lines, HasSubstr("host-sim can --can 'sim' --node 5 set \\\n"));
  EXPECT_THAT(lines, HasSubstr("limits.current_A=0.4"));
}

TEST_F(PageServos, FoxgloveTakesEachSchemaAndItsMessages) {
  bench.bridge.subscribed(2, 1);
  bench.run(1.1);
  for (const Channel& channel : bench.bridge.channels()) {
    if (channel.encoding != Encoding::json) {
      continue;
    }
    const json schema = json::parse(channel.schema);
    EXPECT_EQ(refused_by_foxglove(schema), "") << channel.topic;
    // Each member of a message is in the schema.
    const json message = bench.told.of(channel.id);
    for (const auto& [name, value] : message.items()) {
      EXPECT_TRUE(schema["properties"].contains(name)) << channel.topic << " " << name;
    }
  }
  for (const Service& service : bench.bridge.services()) {
    EXPECT_EQ(refused_by_foxglove(json::parse(service.request_schema)), "") << service.name;
    EXPECT_EQ(refused_by_foxglove(json::parse(service.response_schema)), "") << service.name;
  }
}

}  // namespace
}  // namespace smaservo::page
