#include "firmware/canopen/servo/tuning.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <limits>

#include "tests/firmware/canopen/servo/servo_rig.hpp"

namespace smaservo::canopen::tuning_test {
namespace {

constexpr Key gain{0x2100, 1}, rate{0x2100, 2}, current_limit{0x2020, 2}, current_trip{0x2021, 1},
    command{0x2102, 1}, state{0x2102, 2}, length{0x2110, 1};
constexpr std::uint8_t begin = 1, attempt = 2, commit = 3, revert = 4, leave = 5;

Abort tune(ServoRig& rig, std::uint8_t what) {
  return rig.set(command, what, 1);
}

TEST(Tuning, AGainIsInForceAtOnce) {
  ServoRig rig;
  rig.enable();
  const std::uint32_t before = rig.own.changes();
  EXPECT_EQ(rig.set_real(gain, 12.5F), Abort::none);
  EXPECT_EQ(rig.staging.active().strain.proportional, 12.5);
  EXPECT_EQ(rig.own.changes(), before + 1);
  EXPECT_EQ(rig.get_real(gain), 12.5F);
}

TEST(Tuning, ABadValueLeavesTheOldOneAndIsLogged) {
  ServoRig rig;
  rig.set_real(gain, 3);
  const float inf = std::numeric_limits<float>::infinity();
  const std::uint32_t before = rig.own.changes();
  EXPECT_EQ(rig.set_real(gain, std::numeric_limits<float>::quiet_NaN()), Abort::value);
  EXPECT_EQ(rig.set_real(gain, inf), Abort::value);
  EXPECT_EQ(rig.set_real(gain, -inf), Abort::value);
  EXPECT_EQ(rig.set_real(gain, 2e6F), Abort::too_high);
  EXPECT_EQ(rig.set_real(gain, -1), Abort::too_low);
  EXPECT_EQ(rig.set({0x2022, 1}, 3, 1), Abort::too_high) << "no such choice";
  EXPECT_EQ(rig.get_real(gain), 3.F);
  EXPECT_EQ(rig.own.changes(), before);
  EXPECT_EQ(rig.get({0x2220, 1}), 7U);
  const Bytes log = rig.upload({0x2220, 2}).data;
  ASSERT_EQ(log.size(), 7U * ChangeLog::bytes);
  const auto newest = std::span(log).subspan(20);
  EXPECT_EQ(take_number(newest.subspan(4, 2)), gain.index);
  EXPECT_EQ(newest[6], gain.sub);
  EXPECT_EQ(newest[7], static_cast<std::uint8_t>(Source::sdo));
  EXPECT_EQ(take_number(newest.subspan(8, 4)), as_bits(3.F));
  EXPECT_EQ(take_number(newest.subspan(12, 4)), as_bits(-1.F));
  EXPECT_EQ(take_number(newest.subspan(16, 4)), 0x0609'0032U);
}

/// The newest entry of the log.
LoggedChange newest(ServoRig& rig) {
  const Bytes log = rig.upload({0x2220, 2}).data;
  const auto number = [&](std::size_t at, std::size_t size) {
    return static_cast<std::uint32_t>(take_number(std::span(log).subspan(at, size)));
  };
  return {number(0, 4),
          {static_cast<std::uint16_t>(number(4, 2)), log.at(6)},
          static_cast<Source>(log.at(7)),
          number(8, 4),
          number(12, 4),
          static_cast<Abort>(number(16, 4))};
}

// Whatever is refused, wherever: exact abort, old value kept, one entry with old, new and source.
TEST(Tuning, EveryRefusedWriteIsLogged) {
  ServoRig rig;
  rig.set_real(gain, 3);
  rig.set({0x1017, 0}, 700, 2);
  rig.enable();
  ASSERT_EQ(rig.state(), DriveState::enabled);
  const std::uint32_t three = as_bits(3.F);
  struct Case {
    Key key;
    std::uint32_t value;
    std::size_t size;
    Abort abort;
    std::uint32_t before;
  };
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const auto cases = std::to_array<Case>({
      {gain, as_bits(nan), 4, Abort::value, three},
      {gain, as_bits(-std::numeric_limits<float>::infinity()), 4, Abort::value, three},
      {gain, as_bits(2e6F), 4, Abort::too_high, three},
      {gain, as_bits(-1.F), 4, Abort::too_low, three},
      {gain, 7, 2, Abort::too_short, three},
      {{0x1017, 0}, 7, 4, Abort::too_long, 700},
      {{0x1017, 0}, 7, 1, Abort::too_short, 700},
      {length, as_bits(0.12F), 4, Abort::state, as_bits(0.1F)},
      {{0x1003, 0}, 1, 1, Abort::value, 0},
      {{0x1400, 1}, 0x1C0, 4, Abort::state, 0x201},
      {{0x1400, 2}, 250, 1, Abort::value, 255},
      {{0x1000, 0}, 1, 4, Abort::read_only, servo_device_type},
      {{0x1010, 1}, store_signature, 4, Abort::state, 0},
      {{0x1010, 1}, 1, 4, Abort::transfer, 0},
      {{0x6060, 0}, 9, 1, Abort::value, 1},
      {{0x605A, 0}, 3, 2, Abort::value, 0},
      {{0x2201, 1}, as_bits(nan), 4, Abort::value, 0},
      {{0x2201, 1}, as_bits(26.F), 4, Abort::too_high, 0},
      {{0x2300, 1}, 2, 1, Abort::state, 0},
      {command, attempt, 1, Abort::state, 0},
      {command, 6, 1, Abort::too_high, 0},
  });
  for (const Case& c : cases) {
    SCOPED_TRACE(testing::Message() << std::hex << c.key.index << ':' << int{c.key.sub});
    const std::uint64_t count = rig.get({0x2220, 1});
    EXPECT_EQ(rig.set(c.key, c.value, c.size), c.abort);
    EXPECT_EQ(rig.get({0x2220, 1}), count + 1);
    const LoggedChange last = newest(rig);
    EXPECT_EQ(last.key, c.key);
    EXPECT_EQ(last.source, Source::sdo);
    EXPECT_EQ(last.before, c.before);
    EXPECT_EQ(last.value, c.value);
    EXPECT_EQ(last.result, c.abort);
    if (c.before != 0) {
      EXPECT_EQ(rig.get(c.key), c.before) << "the old value is kept";
    }
  }
}

TEST(Tuning, RefusedSegmentsAndBlocksAreLogged) {
  ServoRig rig;
  rig.set_real(gain, 3);
  EXPECT_EQ(rig.download(gain, Bytes(9)), Abort::too_long) << "announced";
  EXPECT_EQ(newest(rig).result, Abort::too_long);
  rig.ask({0x20, 0x00, 0x21, 1});
  rig.ask({0x0B, 1, 2});
  EXPECT_EQ(newest(rig).result, Abort::too_short);
  EXPECT_EQ(newest(rig).value, 0x201U) << "what has come";
  rig.ask({0xC6, 0x00, 0x21, 1, 4});
  rig.ask({0x81, 0, 0, 0x00, 0x40});
  rig.ask({0xC1 | 3U << 2U, 1, 2});
  EXPECT_EQ(newest(rig).result, Abort::crc);
  EXPECT_EQ(newest(rig).value, as_bits(2.F));
  EXPECT_EQ(newest(rig).before, as_bits(3.F));
  EXPECT_EQ(rig.get({0x2220, 1}), 4U);
}

// A PDO comes a thousand times a second.
TEST(Tuning, WhatAPdoRepeatsIsLoggedOnce) {
  ServoRig rig;
  rig.set({0x1402, 1}, cob_invalid | 0x401U, 4);
  rig.set({0x1602, 1}, 0x2201'0120, 4);
  rig.set({0x1602, 2}, 0x6081'0020, 4);
  rig.set({0x1602, 0}, 2, 1);
  rig.set({0x1402, 1}, 0x401, 4);
  rig.nmt(1);
  const std::uint64_t count = rig.get({0x2220, 1});
  Bytes pdo = little(as_bits(std::numeric_limits<float>::infinity()), 4);
  const Bytes velocity = little(500, 4);
  pdo.insert(pdo.end(), velocity.begin(), velocity.end());
  for (int i = 0; i < 100; ++i) {
    rig.send(0x401, pdo);
    rig.step();
  }
  EXPECT_EQ(rig.get({0x2220, 1}), count + 2) << "the set-point is refused, the velocity changes";
  EXPECT_EQ(newest(rig).key, (Key{0x6081, 0}));
  EXPECT_EQ(newest(rig).source, Source::rpdo);
  EXPECT_EQ(rig.get_real({0x2201, 1}), 0.F);
  EXPECT_EQ(rig.get({0x6081, 0}), 500U);
}

// The keys themselves are not for those who read the log.
TEST(Access, AKeyIsNotLogged) {
  ServoRig rig;
  EXPECT_EQ(rig.set({0x2003, 2}, 0x1234, 2), Abort::too_short);
  EXPECT_EQ(newest(rig).key, (Key{0x2003, 2}));
  EXPECT_EQ(newest(rig).value, 0U);
}

TEST(Tuning, WireAndTripsMayChangeOnlyWithoutHeat) {
  ServoRig rig;
  EXPECT_EQ(rig.set_real(length, 0.11F), Abort::none);
  rig.enable();
  ASSERT_EQ(rig.output.state, DeviceState::running);
  EXPECT_EQ(rig.set_real(length, 0.12F), Abort::state);
  EXPECT_EQ(rig.get_real(length), 0.11F);
}

TEST(Tuning, ASetThatContradictsItselfNamesBoth) {
  ServoRig rig;
  EXPECT_EQ(rig.set_real(current_limit, 0.2F), Abort::incompatible);
  EXPECT_EQ(rig.get({0x2102, 6}), 0x2020'0200U);
  EXPECT_EQ(rig.get({0x2102, 7}), 0x2021'0100U);
  EXPECT_NE(rig.get_real(current_limit), 0.2F);
  EXPECT_EQ(tune(rig, begin), Abort::none);
  EXPECT_EQ(rig.set_real(current_limit, 0.2F), Abort::none);
  EXPECT_EQ(rig.set_real(current_trip, 0.3F), Abort::none) << "the order does not matter";
  EXPECT_NE(rig.staging.active().limits.current_A, 0.2F);
  EXPECT_EQ(tune(rig, commit), Abort::none);
  EXPECT_EQ(static_cast<float>(rig.staging.active().limits.current_A), 0.2F);
}

TEST(Tuning, ATrialGoesBackByItself) {
  ServoRig rig;
  rig.set_real({0x2102, 3}, 2);
  EXPECT_EQ(tune(rig, attempt), Abort::state) << "nothing has begun";
  EXPECT_EQ(tune(rig, begin), Abort::none);
  EXPECT_EQ(tune(rig, begin), Abort::state);
  rig.set_real(gain, 5);
  rig.set_real(rate, 6);
  EXPECT_EQ(rig.staging.active().strain.proportional, 0);
  EXPECT_EQ(tune(rig, attempt), Abort::none);
  EXPECT_EQ(rig.get(state), 2U);
  EXPECT_EQ(rig.staging.active().strain.proportional, 5);
  EXPECT_EQ(rig.staging.active().strain.integral_1_s, 6);
  rig.run(2100);
  EXPECT_EQ(rig.staging.active().strain.proportional, 0);
  EXPECT_EQ(rig.get(state), 0U);
}

TEST(Tuning, AClientThatHasGoneLeavesNothing) {
  ServoRig rig;
  tune(rig, begin);
  rig.set_real(gain, 5);
  tune(rig, attempt);
  for (int i = 0; i < 4; ++i) {
    rig.run(4000);
    EXPECT_EQ(rig.get(state), 2U) << "it still asks";
  }
  rig.run(5100);
  EXPECT_EQ(rig.staging.active().strain.proportional, 0);
  EXPECT_EQ(rig.get(state), 0U);
  tune(rig, begin);
  rig.set_real(gain, 5);
  rig.run(5100);
  EXPECT_EQ(rig.get_real(gain), 0.F) << "nor what was only staged";
}

/// What a client has tried and left lasts for its whole time without anybody, and not longer; what
/// the next one tries is watched as ever.
TEST(Tuning, ATrialThatIsLeftNeedsNobody) {
  ServoRig rig;
  constexpr Key trial_s{0x2102, 3}, timeout_s{0x2102, 4};
  rig.set_real(trial_s, 20);
  tune(rig, begin);
  rig.set_real(gain, 5);
  EXPECT_EQ(tune(rig, leave), Abort::none);
  rig.run(17'000);
  EXPECT_EQ(rig.staging.active().strain.proportional, 5);
  rig.run(3000);
  EXPECT_EQ(rig.staging.active().strain.proportional, 0);
  EXPECT_EQ(rig.get(state), 0U);
  EXPECT_EQ(rig.get_real(timeout_s), 5.F);

  tune(rig, begin);
  rig.set_real(gain, 5);
  tune(rig, leave);
  EXPECT_EQ(tune(rig, attempt), Abort::none) << "somebody else goes on with it";
  rig.run(5100);
  EXPECT_EQ(rig.staging.active().strain.proportional, 0);

  tune(rig, begin);
  rig.set_real(gain, 5);
  rig.run(5100);
  EXPECT_EQ(rig.get(state), 0U) << "what is only staged is never left";
}

TEST(Tuning, CommitKeepsAndRevertForgets) {
  ServoRig rig;
  tune(rig, begin);
  rig.set_real(gain, 5);
  tune(rig, attempt);
  EXPECT_EQ(tune(rig, commit), Abort::none);
  rig.run(40'000);
  EXPECT_EQ(rig.staging.configured().strain.proportional, 5);
  tune(rig, begin);
  rig.set_real(gain, 6);
  tune(rig, attempt);
  EXPECT_EQ(tune(rig, revert), Abort::none);
  EXPECT_EQ(rig.staging.active().strain.proportional, 5);
  EXPECT_EQ(tune(rig, commit), Abort::state);
  EXPECT_EQ(rig.set(command, 6, 1), Abort::too_high);
}

TEST(Tuning, StoringIsSeparate) {
  ServoRig rig;
  rig.set_real(gain, 5);
  EXPECT_FALSE(rig.settings);
  EXPECT_EQ(rig.set({0x1010, 3}, store_signature, 4), Abort::none);
  ASSERT_TRUE(rig.settings);
  EXPECT_EQ(rig.settings->strain.proportional, 5);
}

TEST(Ceilings, NoWriteRaisesThem) {
  ServoConfig config;
  config.ceilings = {.current_A = 0.11F,
                     .power_W = 3,
                     .temperature_K = 400,
                     .stress_Pa = 160e6F,
                     .trip_current_A = 0.16F,
                     .trip_temperature_K = 410,
                     .trip_stress_Pa = 210e6F};
  ServoRig rig(config);
  const auto table = std::to_array<std::pair<Key, float>>({{{0x2020, 2}, 0.11F},
                                                           {{0x2020, 3}, 3},
                                                           {{0x2020, 4}, 400},
                                                           {{0x2020, 8}, 160e6F},
                                                           {{0x2021, 1}, 0.16F},
                                                           {{0x2021, 2}, 410},
                                                           {{0x2021, 3}, 210e6F}});
  for (const auto& [key, ceiling] : table) {
    const float before = rig.get_real(key);
    EXPECT_EQ(rig.set_real(key, 1.01F * ceiling), Abort::too_high) << key.index << ' ' << key.sub;
    EXPECT_EQ(rig.get_real(key), before);
    tune(rig, begin);
    EXPECT_EQ(rig.set_real(key, 1.01F * ceiling), Abort::too_high);
    tune(rig, revert);
  }
}

TEST(Access, LevelsOpenByTheirKeys) {
  ServoConfig config;
  config.keys = {.tune = 1111, .set_up = 2222};
  ServoRig rig(config);
  EXPECT_EQ(rig.get({0x2003, 1}), 0U);
  EXPECT_EQ(rig.set_real(gain, 1), Abort::local);
  EXPECT_EQ(tune(rig, begin), Abort::local);
  rig.set({0x2003, 2}, 1111, 4);
  EXPECT_EQ(rig.get({0x2003, 1}), 1U);
  EXPECT_EQ(rig.set_real(gain, 1), Abort::none);
  EXPECT_EQ(rig.set_real(length, 0.11F), Abort::local);
  rig.set({0x2003, 2}, 2222, 4);
  EXPECT_EQ(rig.set_real(length, 0.11F), Abort::none);
  rig.set({0x2003, 2}, 3, 4);
  EXPECT_EQ(rig.set_real(gain, 2), Abort::local);
  EXPECT_EQ(rig.set({0x1010, 1}, store_signature, 4), Abort::local);
}

TEST(Access, WhatBoundsHeatNeedsTheKeyOfSetUp) {
  ServoConfig config;
  config.keys = {.tune = 1111, .set_up = 2222};
  ServoRig rig(config);
  const auto open = [&](Key key, std::uint64_t value, std::size_t size) {
    for (const std::uint32_t with : {0U, 1111U, 2222U}) {
      rig.set({0x2003, 2}, with, 4);
      if (rig.set(key, value, size) != Abort::local) {
        return rig.get({0x2003, 1});
      }
    }
    return std::uint64_t{3};
  };
  EXPECT_EQ(open({0x2020, 1}, as_bits(0.011F), 4), 2U) << "limits.min_current_A";
  EXPECT_EQ(open({0x2020, 5}, as_bits(18.F), 4), 2U) << "limits.hot_spot_K";
  EXPECT_EQ(open({0x2020, 11}, as_bits(1.1F), 4), 2U) << "limits.loss_margin";
  EXPECT_EQ(open({0x2002, 1}, as_bits(4.F), 4), 2U);
  EXPECT_EQ(open({0x6007, 0}, 0, 2), 2U);
  EXPECT_EQ(open({0x605E, 0}, 2, 2), 2U);
  EXPECT_EQ(open({0x1016, 1}, 0x0010'0190, 4), 2U);
  EXPECT_EQ(open({0x1400, 5}, 100, 2), 2U);
  EXPECT_EQ(open({0x1011, 1}, restore_signature, 4), 2U);
  EXPECT_EQ(open({0x2201, 2}, as_bits(1.F), 4), 1U) << "power without a loop";
  EXPECT_EQ(open({0x6060, 0}, 0xFE, 1), 1U);
  EXPECT_EQ(open({0x2100, 1}, as_bits(1.F), 4), 1U);
  EXPECT_EQ(open({0x607A, 0}, 100, 4), 0U);
  EXPECT_EQ(open({0x6040, 0}, 6, 2), 0U);
  EXPECT_EQ(open({0x6060, 0}, 1, 1), 0U);
}

// Recorder and step test.

std::vector<float> recorded(ServoRig& rig) {
  const Bytes data = rig.upload({0x2300, 11}).data;
  std::vector<float> values;
  for (std::size_t at = 0; at + 4 <= data.size(); at += 4) {
    values.push_back(
        as_real(static_cast<std::uint32_t>(take_number(std::span(data).subspan(at, 4)))));
  }
  return values;
}

TEST(Recorder, KeepsWhatWasBeforeTheTrigger) {
  ServoRig rig;
  rig.enable();
  rig.set({0x2301, 1}, sub_of(signal_index("position_m")), 1);
  for (std::uint8_t i = 2; i <= 8; ++i) {
    rig.set({0x2301, i}, 0, 1);
  }
  EXPECT_EQ(rig.set({0x2301, 2}, signal_count + 1, 1), Abort::value);
  rig.set({0x2300, 4}, 100, 4);
  rig.set({0x2300, 5}, sub_of(signal_index("position_m")), 1);
  rig.set_real({0x2300, 7}, 0.5e-3F);
  ASSERT_EQ(rig.set({0x2300, 1}, 1, 1), Abort::none);
  rig.run(4000);
  EXPECT_EQ(rig.get({0x2300, 2}), 1U) << "it waits";
  EXPECT_EQ(rig.upload({0x2300, 11}).abort, Abort::state);
  rig.set({0x607A, 0}, 1000, 4);
  rig.control(0x1F);
  rig.run(4100);
  EXPECT_EQ(rig.get({0x2300, 2}), 3U);
  const std::vector<float> values = recorded(rig);
  ASSERT_EQ(values.size(), 4096U);
  EXPECT_NEAR(values[99], 0, 1e-6F);
  EXPECT_NEAR(values[100], 1e-3F, 1e-6F);
}

TEST(Recorder, ThinsOutAndRefusesWhatDoesNotFit) {
  ServoRig rig;
  rig.set({0x2300, 3}, 10, 2);
  ASSERT_EQ(rig.set({0x2300, 1}, 1, 1), Abort::none);
  rig.run(1000);
  EXPECT_EQ(rig.get({0x2300, 8}), 100U);
  EXPECT_FLOAT_EQ(rig.get_real({0x2300, 10}), 0.01F);
  rig.set({0x2300, 1}, 0, 1);
  EXPECT_EQ(recorded(rig).size(), 400U);
  rig.set({0x2300, 4}, 100'000, 4);
  EXPECT_EQ(rig.set({0x2300, 1}, 1, 1), Abort::incompatible);
  EXPECT_EQ(rig.set({0x2300, 1}, 2, 1), Abort::state) << "not armed";
}

TEST(StepTest, GoesThereAndBackAndTellsItsFigures) {
  ServoRig rig;
  EXPECT_EQ(rig.set({0x2400, 1}, 1, 1), Abort::state) << "not enabled";
  rig.set({0x6081, 0}, 10'000, 4);
  rig.set({0x2400, 3}, 1000, 4);
  rig.set({0x2400, 4}, 500, 4);
  rig.enable();
  ASSERT_EQ(rig.set({0x2400, 1}, 1, 1), Abort::none);
  rig.run(480);
  EXPECT_EQ(rig.get({0x2400, 2}), 1U);
  EXPECT_EQ(rig.get({0x6064, 0}), 1000U);
  rig.run(600);
  EXPECT_EQ(rig.get({0x2400, 2}), 2U);
  EXPECT_EQ(rig.get({0x6064, 0}), 0U);
  EXPECT_NEAR(rig.get_real({0x2400, 5}), 0.08, 0.005) << "80 % at 10 mm/s";
  EXPECT_NEAR(rig.get_real({0x2400, 6}), 0, 0.001);
  EXPECT_NEAR(rig.get_real({0x2400, 7}), 0.095, 0.005);
  EXPECT_NEAR(rig.get_real({0x2400, 8}), 0, 1e-6);
  EXPECT_EQ(rig.get_real({0x2400, 9}), 300.F);
}

TEST(StepTest, IsBrokenOffByAnythingElse) {
  ServoRig rig;
  rig.enable();
  rig.set({0x2400, 1}, 1, 1);
  rig.run(10);
  rig.set({0x607A, 0}, 77, 4);
  rig.control(0x3F);
  rig.run(10);
  EXPECT_EQ(rig.get({0x2400, 2}), 3U);
}

TEST(LiveValues, AreThoseOfTheStep) {
  ServoRig rig;
  rig.enable();
  EXPECT_FLOAT_EQ(rig.get_real({0x2200, sub_of(signal_index("stress_Pa"))}), 100e6F);
  EXPECT_EQ(rig.get({0x2202, 10}), static_cast<std::uint64_t>(DeviceState::running));
  EXPECT_EQ(rig.get_real({0x2200, sub_of(signal_index("cooling"))}), 0.5F);
  // At a stop the force is the estimated one; what was measured stays what it is.
  const float force_N = rig.get_real({0x2200, sub_of(signal_index("force_N"))});
  EXPECT_NEAR(force_N, 1.36F, 0.01F);
  EXPECT_EQ(rig.get_real({0x2200, sub_of(signal_index("load_estimate_N"))}), force_N);
  rig.servo.set_timing({1000, 3, 1e-6F, 2e-6F, 3e-6F, 4e-6F});
  rig.servo.set_bus(7, 2, 30);
  EXPECT_EQ(rig.get({0x2210, 2}), 3U);
  EXPECT_EQ(rig.get_real({0x2210, 6}), 4e-6F);
  EXPECT_EQ(rig.get({0x2211, 1}), 7U);
  EXPECT_EQ(rig.get({0x2211, 3}), 30U);
}

}  // namespace
}  // namespace smaservo::canopen::tuning_test
