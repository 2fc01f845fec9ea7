#include <algorithm>
#include <fmt/format.h>
#include <random>

#include "tests/host-sim/page/servos/page_servos.hpp"

namespace smaservo::page {
namespace {

TEST_F(PageServos, AreFoundAndSaid) {
  ASSERT_EQ(bridge()["nodes"].size(), 1U);
  EXPECT_EQ(bridge()["nodes"][0],
            json({{"node", 5}, {"name", "smaservo"}, {"online", true}, {"duplicate", false}}));
  EXPECT_EQ(bridge()["control"], nullptr);
  EXPECT_EQ(bridge()["trouble"], "");
  EXPECT_EQ(state()["drive"], "switch_on_disabled");
  std::vector<std::string> topics;
  for (const Channel& channel : bench.bridge.channels()) {
    topics.push_back(channel.topic);
  }
  EXPECT_THAT(topics, testing::ElementsAre("/bridge", "/commission", "/node5/live", "/node5/state",
                                           "/node5/signals"));
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

// A correction of the wall clock that is small is left out, so that times do not go back.
TEST_F(PageServos, MessagesAreDatedByTheWallClock) {
  constexpr std::int64_t s = 1'000'000'000;
  const std::vector<std::int64_t>& times_ns = bench.told.times_ns[1000 + node];
  const auto ahead_ns = [&] { return times_ns.back() - 1000 * bench.bus.now_us(); };
  const std::int64_t begun_ns = bench.wall_at_0_ns;
  bench.run(1);
  EXPECT_LE(ahead_ns(), begun_ns);
  EXPECT_GT(ahead_ns(), begun_ns - s / 10) << "the time of the sample";
  bench.wall_at_0_ns -= s / 20;
  bench.run(3);
  EXPECT_TRUE(std::ranges::is_sorted(times_ns));
  EXPECT_GT(ahead_ns(), begun_ns - s / 20);
  bench.wall_at_0_ns = begun_ns + 3600 * s;
  bench.run(2);
  EXPECT_TRUE(std::ranges::is_sorted(times_ns));
  EXPECT_LE(ahead_ns(), begun_ns + 3600 * s);
  EXPECT_GT(ahead_ns(), begun_ns + 3600 * s - s / 10);
}

TEST_F(PageServos, AreToldInBytesOnlyToWhoAsks) {
  EXPECT_EQ(bench.told.counts[3000 + node], 0U);
  bench.bridge.subscribed(3000 + node, 1);
  bench.run(1);
  EXPECT_GT(bench.told.counts[3000 + node], 50U);
  bench.bridge.subscribed(3000 + node, 0);
  const unsigned before = bench.told.counts[3000 + node];
  bench.run(1);
  EXPECT_EQ(bench.told.counts[3000 + node], before);
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
    if (round % 4 != 1) {
      heat(1);
    }
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

TEST_F(PageServos, ChangesOfOthersAreSeen) {
  const auto port = bench.bus.port();
  can::Remote other(can::SdoClient(*port, node));
  other.set("strain.proportional_W", "3.5");
  bench.run(1);
  EXPECT_EQ(bench.get("node5.strain.proportional_W"), "3.5");
  EXPECT_EQ(bench.told.parameters["node5.strain.proportional_W"], "3.5");
  EXPECT_EQ(state()["unsaved"], true);
}

// Whatever answer is lost on the way, the page has the value in the end.
TEST_F(PageServos, AChangeIsSeenThoughAnswersAreLost) {
  for (int first = 0; first < 12; ++first) {
    const std::string value = fmt::format("{}.5", 2 + first);
    const auto port = bench.bus.port();
    can::Remote other(can::SdoClient(*port, node));
    other.set("strain.proportional_W", value);
    // Both answers to one read, and all of the next one.
    int answers = 0;
    bench.bus.loses = [&](const hal::CanFrame& frame) {
      if (frame.id != 0x580 + node) {
        return false;
      }
      ++answers;
      return first <= answers && answers < first + 3;
    };
    bench.run(4);
    bench.bus.loses = nullptr;
    EXPECT_EQ(bench.told.parameters.at("node5.strain.proportional_W"), value) << first;
  }
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
  EXPECT_GT(state()["freeze_frame"]["wire_temperature_K"].get<double>(), 300);
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
    if (++receives == 100) {
      bench.bus.connect(0, false);
    }
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

TEST_F(PageServos, ABridgeThatDidNotRunSaysThatTheComputerIsTooBusy) {
  bench.run(1);
  bench.bus.stand_still(0.4);
  bench.run(0.1);
  EXPECT_EQ(bridge()["trouble"], "");
  bench.bus.stand_still(0.7);
  testing::internal::CaptureStderr();
  bench.run(0.1);
  EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("did not run for 0.7 s"));
  EXPECT_THAT(bridge()["trouble"].get<std::string>(), HasSubstr("this computer is too busy"));
  bench.run(4);
  EXPECT_EQ(bridge()["trouble"], "") << "it is over";
}

TEST_F(PageServos, TheLogSaysWhoseGoingEndedTheHeat) {
  heat(1);
  testing::internal::CaptureStderr();
  bench.bridge.client_left(1);
  EXPECT_THAT(testing::internal::GetCapturedStderr(),
              HasSubstr("heat of node 5 ended: client 1, who had control, is gone"));
  bench.run(1);
  EXPECT_EQ(flowing_A(), 0);
}

}  // namespace
}  // namespace smaservo::page
