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
  plan.sync_signals = {"strain",          "wire_temperature_K", "resistance_ohm",
                       "drive_current_A", "setpoint",           "power_W",
                       "stress_Pa",       "position_m"};
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
class AnySequence {
 public:
  explicit AnySequence(unsigned seed) : seed_(seed), bench_({5, 6}), random_(seed) {
    bench_.run(1);
  }

  void step() {
    client_ = std::array{1U, 2U, 3U, reader}[pick(4)];
    context_ = fmt::format("seed {} step {} client {}", seed_, ++steps_, client_);
    if (pick(10) < 7) {
      write();
    } else {
      pass_control();
      bench_.run(0.003);
    }
    ASSERT_EQ(bench_.bridge.control().client(), control_) << context_;
    if (!control_) {
      ASSERT_EQ(bench_.bus.all_flowing_A(), 0) << context_;
    }
    bench_.run(0.05);
  }

 private:
  static constexpr unsigned reader = 9;  // may not write

  std::size_t pick(std::size_t n) {
    return std::uniform_int_distribution<std::size_t>(0, n - 1)(random_);
  }

  std::string some_write(unsigned node) {
    const std::string at = fmt::format("{{\"node\":{}", node);
    switch (pick(5)) {
      case 0:
        return bench_.call(client_, "enable", at + "}").text;
      case 1:
        return bench_.call(client_, "mode", at + ",\"mode\":1}").text;
      case 2:
        return bench_.call(client_, "target", fmt::format("{},\"value\":{}}}", at, pick(900))).text;
      case 3:
        return bench_.call(client_, "disable", at + "}").text;
      default:
        return bench_.set(client_, {{fmt::format("node{}.strain.proportional_W", node),
                                     fmt::format("{}", 1 + pick(5))}});
    }
  }

  void write() {
    const unsigned node = 5 + unsigned(pick(2));
    const auto settings = [&] { return bench_.bus.servo(node - 5).servo().settings(); };
    const bool may = client_ != reader && (!control_ || *control_ == client_);
    const Settings<double> before = settings();
    const std::string answer = some_write(node);
    const bool refused_for_control = answer.find("has control") != std::string::npos ||
                                     answer.find("read-only") != std::string::npos;
    ASSERT_EQ(refused_for_control, !may) << context_ << answer;
    if (may) {
      control_ = client_;
    } else {
      ASSERT_TRUE(same_settings(before, settings())) << context_;
    }
  }

  void pass_control() {
    const bool has = control_ == client_;
    switch (pick(4)) {
      case 0:
        bench_.call(client_, "take_control");
        if (client_ != reader) {
          control_ = client_;
        }
        break;
      case 1:
        bench_.call(client_, "release_control");
        if (has) {
          control_.reset();
        }
        break;
      case 2:
        bench_.bridge.client_left(client_);
        if (has) {
          control_.reset();
        }
        break;
      default:
        ASSERT_TRUE(bench_.call(client_, "stop").ok) << context_;
        ASSERT_EQ(bench_.bus.all_flowing_A(), 0) << context_;
    }
  }

  unsigned seed_;
  BridgeBench bench_;
  std::mt19937_64 random_;
  std::optional<unsigned> control_;  // the model
  unsigned client_ = 0;
  int steps_ = 0;
  std::string context_;
};

TEST(PageServosOfABus, ObeyTheRulesOfControlInAnySequence) {
  for (unsigned seed = 1; seed <= 6; ++seed) {
    AnySequence sequence(seed);
    for (int i = 0; i < 120; ++i) {
      sequence.step();
      if (testing::Test::HasFatalFailure()) {
        return;
      }
    }
  }
}

}  // namespace
}  // namespace smaservo::page
