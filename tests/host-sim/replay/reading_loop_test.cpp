#include "host-sim/replay/rows/reading_loop.hpp"

#include <array>
#include <bit>
#include <cmath>
#include <gtest/gtest.h>

#include "model/files/error.hpp"
#include "observer/estimator.hpp"
#include "tests/observer/shipped_traces.hpp"

namespace smaservo::replay {
namespace {

using Bits = std::array<std::uint64_t, 6>;
Bits bits(const Estimate<double>& e) {
  return std::bit_cast<Bits>(std::array{e.strain, e.strain_sd, e.temperature_K, e.martensite,
                                        e.r_phase, e.resistance_model_ohm});
}

std::int64_t nanoseconds(double time_s) {
  return static_cast<std::int64_t>(std::llround(1e9 * time_s));
}

/// The steps of a trace, some of them after a longer time.
TEST(ReadingLoop, IsAnEstimatorThatStartsAgainAfterAMinute) {
  const ShippedTrace trace = shipped_traces().front();
  const Wire<double> wire = load_unit(trace);
  std::vector<TraceStep> steps = load_trace(trace);
  ASSERT_GT(steps.size(), 4000U);
  steps[1000].dt_s = 59.0;
  steps[2000].dt_s = 61.0;
  ReadingLoop loop(wire, {}, {"kalman", "open-loop"});
  Estimator estimator{wire};
  std::int64_t now_ns = 0;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const std::int64_t last_ns = now_ns;
    now_ns += nanoseconds(steps[i].dt_s);
    const bool again = loop.add(steps[i].sample, {now_ns, 0, room_K});
    ASSERT_EQ(again, i == 2000) << i;
    const double dt_s = static_cast<double>(now_ns - last_ns) * 1e-9;
    ASSERT_EQ(bits(loop.estimate()), bits(estimator.update(steps[i].sample, dt_s))) << i;
  }
}

TEST(ReadingLoop, StartsAgainWithANewPieceFromTheAirOfItsRow) {
  const ShippedTrace trace = shipped_traces().front();
  const Wire<double> wire = load_unit(trace);
  const std::vector<TraceStep> steps = load_trace(trace);
  ReadingLoop loop(wire, {}, {"kalman"});
  for (std::size_t i = 0; i < 100; ++i) {
    EXPECT_FALSE(loop.add(steps[i].sample, {nanoseconds(0.01 * static_cast<double>(i)), 0, 280}));
  }
  EXPECT_TRUE(loop.add(steps[100].sample, {nanoseconds(1), 1, 310}));
  ReadingLoop fresh(wire, {}, {"kalman"});
  EXPECT_FALSE(fresh.add(steps[100].sample, {nanoseconds(1), 0, 310}));
  EXPECT_EQ(bits(loop.estimate()), bits(fresh.estimate()));
  ReadingLoop colder(wire, {}, {"kalman"});
  colder.add(steps[100].sample, {nanoseconds(1), 0, 280});
  EXPECT_NE(bits(loop.estimate()), bits(colder.estimate()));
}

TEST(ReadingLoop, RefusesAnObserverThatIsNone) {
  const Wire<double> wire = load_unit(shipped_traces().front());
  EXPECT_THROW(ReadingLoop(wire, {}, {"kalmann"}), files::UserError);
}

}  // namespace
}  // namespace smaservo::replay
