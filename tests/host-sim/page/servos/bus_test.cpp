// Several servos, other masters, SYNC, any sequence of requests.

#include <array>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <random>

#include "tests/host-sim/page/servos/servo_bench.hpp"

namespace smaservo::page {
namespace {

using nlohmann::json;
using test::BridgeBench;
using testing::HasSubstr;

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
