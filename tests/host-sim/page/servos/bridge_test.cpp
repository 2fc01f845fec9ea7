#include <cmath>
#include <fmt/format.h>
#include <gmock/gmock.h>

#include "tests/host-sim/page/servos/servo_bench.hpp"

namespace smaservo::page {
namespace {

using nlohmann::json;
using test::BridgeBench;
using testing::HasSubstr;

/// A current that warms: the least that a running device gives is below that.
constexpr double some_A = 0.02;

struct PageServos : testing::Test {
  static constexpr unsigned node = 5;

  BridgeBench bench{{node}};

  PageServos() {
    bench.watch(node);
    bench.run(1);
  }
  json state() { return bench.told.of(2000 + node); }
  json bridge() { return bench.told.of(1); }
  double flowing_A() { return bench.bus.flowing_A(0); }
  void heat(unsigned client) {
    ASSERT_EQ(bench.call(client, "enable", R"({"node":5})").text, "{}");
    ASSERT_EQ(bench.call(client, "mode", R"({"node":5,"mode":1})").text, "{}");
    ASSERT_EQ(bench.call(client, "target", R"({"node":5,"value":800})").text, "{}");
    bench.run(0.1);
    ASSERT_GT(flowing_A(), some_A);
  }
  can::Bytes read(Key key) {
    const auto port = bench.bus.port();
    can::SdoClient client(*port, node);
    return client.upload(key);
  }
  float watch_s() {
    return canopen::as_real(static_cast<std::uint32_t>(canopen::take_number(read({0x2002, 1}))));
  }
};

TEST_F(PageServos, AreFoundAndSaid) {
  ASSERT_EQ(bridge()["nodes"].size(), 1U);
  EXPECT_EQ(bridge()["nodes"][0],
            json({{"node", 5}, {"name", "smaservo"}, {"online", true}, {"duplicate", false}}));
  EXPECT_EQ(bridge()["control"], nullptr);
  EXPECT_EQ(bridge()["trouble"], "");
  EXPECT_EQ(state()["drive"], "switch_on_disabled");
  std::vector<std::string> topics;
  for (const Channel& channel : bench.bridge.channels()) topics.push_back(channel.topic);
  EXPECT_THAT(topics, testing::ElementsAre("/bridge", "/node5/live", "/node5/state"));
  EXPECT_GT(bench.told.channel_lists, 0U);
  EXPECT_EQ(bench.get("node5.limits.current_A"), "0.4");
}

TEST_F(PageServos, LiveValuesAreThoseOfTheServoAtThePromisedRate) {
  const unsigned before = bench.told.counts[1000 + node];
  bench.run(2);
  EXPECT_GE(bench.told.counts[1000 + node] - before, 100U);
  const json live = bench.told.of(1000 + node);
  EXPECT_EQ(live.size(), signal_count);
  const auto strain = static_cast<double>(
      canopen::as_real(static_cast<std::uint32_t>(canopen::take_number(read({0x2200, 1})))));
  EXPECT_NEAR(live["strain"].get<double>(), strain, 1e-4);
  EXPECT_EQ(state()["gaps"], 0);
  EXPECT_GT(state()["rate_hz"].get<double>(), 50);
}

TEST_F(PageServos, MoveAndCool) {
  heat(1);
  bench.run(3);
  EXPECT_NEAR(state()["position_um"].get<double>(), 800, 120);
  EXPECT_EQ(state()["drive"], "operation_enabled");
  EXPECT_EQ(state()["target"], 800);
  EXPECT_EQ(state()["mode_name"], "profile position");
  EXPECT_EQ(bridge()["control"], 1);
  ASSERT_TRUE(bench.call(1, "disable", R"({"node":5})").ok);
  EXPECT_EQ(flowing_A(), 0);
}

// The watch of the servo is short only while a client keeps it enabled, and is renewed.
TEST_F(PageServos, HeatEndsWithTheBridge) {
  ASSERT_EQ(watch_s(), 5);
  heat(1);
  EXPECT_EQ(watch_s(), 1);
  bench.run(10);
  EXPECT_GT(flowing_A(), some_A) << "it is renewed";
  bench.bus.run(0.6);
  EXPECT_GT(flowing_A(), some_A);
  bench.bus.run(0.5);  // the bridge is dead: nothing of it runs
  EXPECT_EQ(flowing_A(), 0);
}

TEST_F(PageServos, HeatEndsWithItsClient) {
  for (const bool says_so : {true, false}) {
    heat(2);
    if (says_so) {
      bench.bridge.client_left(2);
    } else {
      std::erase_if(bench.told.present, [](const ClientState& c) { return c.client == 2; });
      bench.run(0.3);
    }
    bench.bus.run(0.003);
    EXPECT_EQ(flowing_A(), 0) << says_so;
    bench.run(0.5);
    EXPECT_EQ(watch_s(), 5) << "it is put back";
    EXPECT_EQ(bridge()["control"], nullptr);
    EXPECT_EQ(state()["drive"], "switch_on_disabled");
  }
}

TEST_F(PageServos, OneWritesAtATime) {
  heat(1);
  EXPECT_THAT(bench.call(2, "target", R"({"node":5,"value":0})").text,
              HasSubstr("client 1 has control"));
  EXPECT_THAT(bench.set(2, {{"node5.strain.proportional_W", "3"}}),
              HasSubstr("client 1 has control"));
  EXPECT_THAT(bench.call(9, "enable", R"({"node":5})").text, HasSubstr("read-only"));
  EXPECT_THAT(bench.call(9, "take_control").text, HasSubstr("read-only"));
  EXPECT_GT(flowing_A(), some_A);
  EXPECT_EQ(bench.call(2, "take_control").json()["control"], 2);
  bench.bus.run(0.003);
  EXPECT_EQ(flowing_A(), 0) << "at once, without the bridge's thread";
  EXPECT_EQ(bench.call(1, "release_control").json()["control"], 2) << "of nobody else's";
  EXPECT_EQ(bench.call(2, "release_control").json()["control"], nullptr);
}

// A read-only client may stop everything, also in the middle of whatever the bus is doing.
TEST_F(PageServos, StopActsAtOnceInTheMiddleOfAnything) {
  struct Case {
    const char* service;
    const char* request;
  };
  const Case cases[] = {
      {"step", R"({"node":5,"amplitude_um":500,"seconds":0.5})"},
      {"enable", R"({"node":5})"},
      {"dump", R"({"node":5,"as":"toml"})"},
      {"target", R"({"node":5,"value":300})"},
  };
  std::mt19937_64 random(20);
  for (int round = 0; round < 24; ++round) {
    const Case& c = cases[static_cast<std::size_t>(round) % std::size(cases)];
    if (round % 4 != 1) heat(1);
    const int at = std::uniform_int_distribution<int>(1, round % 4 == 0 ? 1500 : 120)(random);
    int receives = 0;
    std::shared_ptr<BridgeBench::Got> stop;
    std::int64_t stopped_us = 0;
    bench.bus.before_receive = [&] {
      if (++receives == at && !stop) {
        stop = bench.ask(9, "stop", "{}");
        stopped_us = bench.bus.now_us();
      }
      if (stop && bench.bus.now_us() > stopped_us + 3000) {
        ASSERT_EQ(flowing_A(), 0) << c.service << " at " << at;
      }
    };
    const auto got = bench.ask(1, c.service, c.request);
    bench.run(4);
    bench.bus.before_receive = {};
    ASSERT_TRUE(got->done) << c.service;
    ASSERT_TRUE(stop && stop->done);
    EXPECT_TRUE(stop->ok) << stop->text;
    EXPECT_EQ(flowing_A(), 0);
  }
}

TEST_F(PageServos, ATrialRevertsByItselfAndWithItsClient) {
  const std::string gain = "node5.strain.proportional_W";
  ASSERT_EQ(bench.set(1, {{gain, "2"}}), "");
  EXPECT_EQ(bench.get(gain), "2.0");
  const std::string request = R"({"node":5,"values":{"strain.proportional_W":7},"seconds":2})";
  const auto in_force = [&] { return bench.bus.servo(0).servo().settings().strain.proportional; };
  ASSERT_EQ(bench.call(1, "try", request).text, "{}");
  bench.run(0.5);
  EXPECT_EQ(state()["transaction"]["state"], "trying");
  EXPECT_NEAR(state()["transaction"]["seconds_left"].get<double>(), 1.5, 0.3);
  EXPECT_EQ(in_force(), 7);
  EXPECT_THAT(bench.set(1, {{gain, "4"}}), HasSubstr("a trial is going on"));
  bench.run(2.5);
  EXPECT_EQ(in_force(), 2);
  EXPECT_EQ(bench.get(gain), "2.0") << "the bridge has heard of it";
  ASSERT_EQ(bench.call(1, "try", request).text, "{}");
  bench.bridge.client_left(1);
  bench.run(0.5);
  EXPECT_EQ(in_force(), 2);
  ASSERT_EQ(bench.call(2, "try", request).text, "{}");
  ASSERT_EQ(bench.call(2, "commit", R"({"node":5})").text, "{}");
  bench.run(3);
  EXPECT_EQ(in_force(), 7);
  EXPECT_EQ(state()["unsaved"], true);
  ASSERT_EQ(bench.call(2, "store", R"({"node":5})").text, "{}");
  bench.run(0.5);
  EXPECT_EQ(state()["unsaved"], false);
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
  EXPECT_THAT(refused("export", R"({"recording":3,"as":"xls"})"), HasSubstr("must be csv"));
  EXPECT_EQ(bench.id_of("nonsense"), 0U);
  EXPECT_THAT(refused("nonsense", "{}"), HasSubstr("no such service"));
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
  EXPECT_EQ(bench.call(9, "export", by_id).text, file.text);
  // Others go on while a recording waits for its trigger.
  const auto recorded =
      bench.ask(2, "record",
                R"({"node":5,"signals":["temperature_K","current_A"],"seconds":0.5,"before_s":0.1,
          "trigger":"temperature_K>310"})");
  bench.run(1);
  EXPECT_FALSE(recorded->done);
  heat(1);
  bench.run(3);
  ASSERT_TRUE(recorded->ok) << recorded->text;
  const json rows = recorded->json()["recording"]["rows"];
  ASSERT_EQ(rows.size(), 500U);
  EXPECT_LT(rows.front()[0].get<double>(), 310);
  EXPECT_LT(rows[99][0].get<double>(), 310);
  EXPECT_GE(rows[100][0].get<double>(), 310) << "the trigger";
  EXPECT_GT(rows.back()[0].get<double>(), 310);
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
  EXPECT_EQ(bench.call(1, "restore", request).json()["changed"], json({"limits.power_W"}));
  EXPECT_TRUE(same_settings(before, bench.bus.servo(0).servo().settings()));
  const std::string lines =
      bench.call(2, "dump", R"({"node":5,"as":"can"})").json()["text"].get<std::string>();
  EXPECT_THAT(lines, HasSubstr("host-sim can --can sim --node 5 set \\\n"));
  EXPECT_THAT(lines, HasSubstr("limits.current_A=0.4"));
}

TEST_F(PageServos, ChangesOfOthersAreSeen) {
  const auto port = bench.bus.port();
  can::Remote other(can::SdoClient(*port, node));
  other.set("strain.proportional_W", "3.5");
  bench.run(1);
  EXPECT_EQ(bench.get("node5.strain.proportional_W"), "3.5");
  EXPECT_EQ(bench.told.parameters["node5.strain.proportional_W"], "3.5");
  EXPECT_EQ(state()["unsaved"], true);
}

TEST_F(PageServos, AFaultIsSaidWithItsCauseAndTheValuesOfThatTime) {
  heat(1);
  bench.run(1);
  auto& tamper = bench.bus.servo(0).rig().tamper_inputs;
  const auto usual = tamper;
  tamper = [&](Inputs<double>& in) {
    usual(in);
    in.external.add(Fault::emergency_stop, true);
  };
  bench.run(1);
  tamper = usual;
  bench.run(0.3);
  EXPECT_EQ(state()["drive"], "fault");
  EXPECT_EQ(state()["latched"], json({"emergency_stop"}));
  EXPECT_EQ(state()["first_cause"], "emergency_stop");
  EXPECT_GT(state()["freeze_frame"]["temperature_K"].get<double>(), 300);
  EXPECT_EQ(flowing_A(), 0);
  EXPECT_EQ(watch_s(), 5);
  ASSERT_EQ(bench.call(1, "reset_faults", R"({"node":5})").text, "{}");
  bench.run(0.5);
  EXPECT_EQ(state()["drive"], "switch_on_disabled");
  EXPECT_EQ(state()["freeze_frame"], nullptr);
}

TEST_F(PageServos, OneThatDisappearsInATransferIsMissedAndFoundAgain) {
  heat(1);
  int receives = 0;
  bench.bus.before_receive = [&] {
    if (++receives == 100) bench.bus.connect(0, false);
  };
  const BridgeBench::Got got = bench.call(2, "dump", R"({"node":5,"as":"toml"})");
  bench.bus.before_receive = {};
  EXPECT_THAT(got.text, HasSubstr("no answer"));
  bench.run(2);
  EXPECT_EQ(flowing_A(), 0) << "its watch";
  EXPECT_EQ(bridge()["nodes"][0]["online"], false);
  EXPECT_THAT(bench.call(1, "enable", R"({"node":5})").text, HasSubstr("does not answer"));
  EXPECT_FALSE(bench.call(9, "stop").ok) << "nobody knows yet";
  bench.run(12);
  EXPECT_TRUE(bench.call(9, "stop").ok) << "its own watch has ended its heat long ago";
  bench.bus.connect(0, true);
  bench.run(2);
  EXPECT_EQ(bridge()["nodes"][0]["online"], true);
  EXPECT_EQ(flowing_A(), 0);
  EXPECT_EQ(bridge()["trouble"], "");
}

TEST_F(PageServos, ABusThatGoesDownIsSaidAndComesBack) {
  heat(1);
  bench.bus.down = true;
  bench.run(3);
  EXPECT_THAT(bridge()["trouble"].get<std::string>(), HasSubstr("the interface is down"));
  EXPECT_EQ(flowing_A(), 0) << "its watch";
  EXPECT_FALSE(bench.call(1, "target", R"({"node":5,"value":100})").ok);
  bench.bus.down = false;
  bench.run(4);
  EXPECT_EQ(bridge()["trouble"], "");
  EXPECT_EQ(bridge()["nodes"][0]["online"], true);
  EXPECT_EQ(flowing_A(), 0);
}

TEST(PageServosOfABus, TwoWithOneNodeIdAreSaidAndNotCommanded) {
  BridgeBench bench({5, 7});
  bench.watch(5);
  bench.run(1);
  ASSERT_TRUE(bench.call(1, "enable", R"({"node":5})").ok);
  bench.bus.add(5);
  bench.run(3);
  const json nodes = bench.told.of(1)["nodes"];
  EXPECT_EQ(nodes[0]["duplicate"], true);
  EXPECT_EQ(nodes[1]["duplicate"], false);
  EXPECT_EQ(bench.bus.all_flowing_A(), 0);
  EXPECT_THAT(bench.call(1, "enable", R"({"node":5})").text,
              HasSubstr("two devices answer under this node-id"));
  EXPECT_TRUE(bench.call(1, "enable", R"({"node":7})").ok);
  bench.bus.connect(2, false);
  bench.run(10);
  EXPECT_EQ(bench.told.of(1)["nodes"][0]["duplicate"], false);
}

TEST(PageServosOfABus, OtherMastersMakeNoDuplicate) {
  BridgeBench bench({5});
  bench.watch(5);
  bench.run(1);
  const auto port = bench.bus.port();
  can::SdoClient other(*port, 5);
  for (int i = 0; i < 300; ++i) {
    other.upload({0x6041, 0});
    other.upload({0x2200, 1});
    bench.run(0.01);
  }
  EXPECT_EQ(bench.told.of(1)["nodes"][0]["duplicate"], false);
}

TEST(PageServosOfABus, NoRequestRaisesACeiling) {
  canopen::ServoConfig config;
  config.ceilings.current_A = 0.45F;
  BridgeBench bench({5}, BridgeBench::usual_plan(), config);
  bench.run(1);
  EXPECT_THAT(bench.set(1, {{"node5.limits.current_A", "0.5"}}), HasSubstr("too high"));
  EXPECT_THAT(
      bench.call(1, "try", R"({"node":5,"values":{"limits.current_A":0.5},"seconds":9})").text,
      HasSubstr("too high"));
  EXPECT_FLOAT_EQ(float(bench.bus.servo(0).servo().settings().limits.current_A), 0.4F);
}

TEST(PageServosOfABus, ComeBySyncAtTheFullRateAndKeepTheirMapping) {
  BridgePlan plan = BridgeBench::usual_plan();
  plan.sync_s = 0.001;
  plan.sync_signals = {"strain",   "temperature_K", "resistance_ohm", "current_A",
                       "setpoint", "power_W",       "stress_Pa",      "position_m"};
  BridgeBench bench({5, 6}, plan);
  const auto mapping = [&] {
    const auto port = bench.bus.port();
    can::SdoClient client(*port, 5);
    std::vector<can::Bytes> all;
    for (std::uint16_t pdo = 0; pdo < 4; ++pdo) {
      for (const std::uint8_t sub : std::to_array<std::uint8_t>({1, 2, 3, 5})) {
        all.push_back(client.upload({std::uint16_t(0x1800 + pdo), sub}));
      }
      for (std::uint8_t sub = 0; sub <= 8; ++sub) {
        all.push_back(client.upload({std::uint16_t(0x1A00 + pdo), sub}));
      }
    }
    return all;
  };
  const auto before = mapping();
  bench.watch(5);
  bench.watch(6);
  bench.run(3);
  EXPECT_NE(mapping(), before);
  ASSERT_TRUE(bench.call(1, "enable", R"({"node":5})").ok);
  bench.run(1);
  EXPECT_NEAR(bench.told.of(2005)["rate_hz"].get<double>(), 1000, 1);
  EXPECT_NEAR(bench.told.of(2006)["rate_hz"].get<double>(), 1000, 1);
  EXPECT_EQ(bench.told.of(2005)["gaps"], 0);
  EXPECT_EQ(bench.told.of(2005)["unsaved"], false);
  // A long transfer of the same servo costs no sample.
  ASSERT_TRUE(bench.call(1, "dump", R"({"node":5,"as":"toml"})").ok);
  bench.run(1);
  EXPECT_EQ(bench.told.of(2005)["gaps"], 0);
  // What is lost is counted.
  int lost = 0;
  bench.bus.loses = [&, n = 0](const hal::CanFrame& frame) mutable {
    const bool loses = frame.id == 0x385 && ++n % 100 == 0;
    lost += loses ? 1 : 0;
    return loses;
  };
  bench.run(2);
  bench.bus.loses = {};
  bench.run(1);
  ASSERT_GE(lost, 19);
  EXPECT_EQ(bench.told.of(2005)["gaps"], lost);
  EXPECT_EQ(bench.told.of(2006)["gaps"], 0);
  bench.bridge.stop();
  EXPECT_EQ(mapping(), before);
  EXPECT_EQ(bench.bus.all_flowing_A(), 0);
}

// Any sequence of requests: only who has control changes anything, and current flows only while
// somebody has it.
TEST(PageServosOfABus, ObeyTheRulesOfControlInAnySequence) {
  for (unsigned seed = 1; seed <= 6; ++seed) {
    BridgeBench bench({5, 6});
    bench.run(1);
    std::mt19937_64 random(seed);
    const auto pick = [&](std::size_t n) {
      return std::uniform_int_distribution<std::size_t>(0, n - 1)(random);
    };
    std::optional<unsigned> control;  // the model
    const unsigned clients[] = {1, 2, 3, 9};
    for (int i = 0; i < 120; ++i) {
      const unsigned client = clients[pick(4)];
      const unsigned node = 5 + unsigned(pick(2));
      const std::string at = fmt::format("{{\"node\":{}", node);
      const bool writes = pick(10) < 7;
      const std::string context = fmt::format("seed {} step {} client {}", seed, i, client);
      if (writes) {
        const bool may = client != 9 && (!control || *control == client);
        const Settings<double> before = bench.bus.servo(node - 5).servo().settings();
        std::string answer;
        switch (pick(5)) {
          case 0:
            answer = bench.call(client, "enable", at + "}").text;
            break;
          case 1:
            answer = bench.call(client, "mode", at + ",\"mode\":1}").text;
            break;
          case 2:
            answer =
                bench.call(client, "target", fmt::format("{},\"value\":{}}}", at, pick(900))).text;
            break;
          case 3:
            answer = bench.call(client, "disable", at + "}").text;
            break;
          default:
            answer = bench.set(client, {{fmt::format("node{}.strain.proportional_W", node),
                                         fmt::format("{}", 1 + pick(5))}});
        }
        const bool refused_for_control = answer.find("has control") != std::string::npos ||
                                         answer.find("read-only") != std::string::npos;
        ASSERT_EQ(refused_for_control, !may) << context << answer;
        if (may && client != 9) control = client;
        if (!may) {
          ASSERT_TRUE(same_settings(before, bench.bus.servo(node - 5).servo().settings()))
              << context;
        }
      } else {
        switch (pick(4)) {
          case 0:
            bench.call(client, "take_control");
            if (client != 9) control = client;
            break;
          case 1:
            bench.call(client, "release_control");
            if (control == client) control.reset();
            break;
          case 2:
            bench.bridge.client_left(client);
            if (control == client) control.reset();
            break;
          default:
            ASSERT_TRUE(bench.call(client, "stop").ok) << context;
            ASSERT_EQ(bench.bus.all_flowing_A(), 0) << context;
        }
        bench.run(0.003);
      }
      ASSERT_EQ(bench.bridge.control().client(), control) << context;
      if (!control) {
        ASSERT_EQ(bench.bus.all_flowing_A(), 0) << context;
      }
      bench.run(0.05);
    }
  }
}

}  // namespace
}  // namespace smaservo::page
