#include "firmware/safety/deglitch.hpp"

#include <gtest/gtest.h>

namespace smaservo::deglitch_test {
namespace {

constexpr double dt_s = 1e-3;

/// Steps until it is active, counted from the first that sees the condition.
int steps_until_active(Fault fault) {
  Deglitch<float> d{};
  for (int i = 0; i < 10000; ++i) {
    if (d.step(fault, static_cast<float>(dt_s)).has(fault)) {
      return i;
    }
  }
  return -1;
}

TEST(Deglitch, LastsAsLongAsTheTableSays) {
  for (const FaultRow& row : fault_rows) {
    EXPECT_NEAR(steps_until_active(row.fault) * dt_s, row.deglitch_s,
                1.5 * dt_s + 1e-3 * row.deglitch_s)
        << row.name;
  }
}

TEST(Deglitch, ABriefConditionIsForgotten) {
  Deglitch<double> d{};
  d.step(Fault::load_lost, dt_s);  // 20 ms
  for (int i = 0; i < 10; ++i) {
    EXPECT_TRUE(d.step(Fault::load_lost, dt_s).empty());
  }
  for (int i = 0; i < 11; ++i) {
    EXPECT_TRUE(d.step({}, dt_s).empty());
  }
  EXPECT_TRUE(d.pending.empty());
}

TEST(Deglitch, ALooseContactTrips) {
  Deglitch<double> d{};
  bool tripped = false;
  for (int i = 0; i < 200 && !tripped; ++i) {
    tripped =
        d.step(i % 4 != 0 ? FaultSet(Fault::load_lost) : FaultSet{}, dt_s).has(Fault::load_lost);
  }
  EXPECT_TRUE(tripped);
}

TEST(Deglitch, OneDoesNotChangeAnother) {
  Deglitch<double> alone{};
  Deglitch<double> both{};
  for (int i = 0; i < 100; ++i) {
    const FaultSet open = i % 7 < 5 ? FaultSet(Fault::wire_open) : FaultSet{};
    const FaultSet other = i % 3 == 0 ? FaultSet(Fault::load_lost) : FaultSet{};
    EXPECT_EQ(alone.step(open, dt_s).has(Fault::wire_open),
              both.step(open | other, dt_s).has(Fault::wire_open));
  }
}

}  // namespace
}  // namespace smaservo::deglitch_test
