// The device in integer arithmetic (model/scalar/scaled.hpp) against the one in double: its PID,
// and all of it in a closed loop.

#include "model/scalar/scaled.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <random>
#include <vector>

#include "tests/firmware/device/test_device.hpp"

namespace smaservo::scaled_device_test {
namespace {

/// Random gains of a strain's loop, in watts.
template <class S>
LoopGains<S> gains(std::mt19937_64& random) {
  std::uniform_real_distribution<double> share;
  const auto up_to = [&](double max) { return scalar<S>(max * share(random)); };
  LoopGains<S> q{};
  q.proportional = up_to(200);
  q.integral_1_s = up_to(20);
  q.derivative_s = up_to(0.05);
  q.derivative_filter_s = scalar<S>(0.002 + 0.01 * share(random));
  q.setpoint_weight = up_to(1);
  q.derivative_weight = up_to(1);
  q.tracking_s = scalar<S>(0.01 + 0.1 * share(random));
  q.cooling_factor = scalar<S>(0.5 + share(random));
  q.dead_band = up_to(1e-4);
  return q;
}

/// Powers of a loop whose reference and measurement wander, with limits of its output.
template <class S>
std::vector<double> powers_W(unsigned seed) {
  std::mt19937_64 random(seed);
  const LoopGains<S> q = gains<S>(random);
  std::uniform_real_distribution<double> any(-1, 1);
  double reference = 0.01;
  double measured = 0.02;
  auto s = Pid<S>::start(q, scalar<S>(reference), scalar<S>(measured));
  std::vector<double> powers;
  for (int i = 0; i < 3000; ++i) {
    reference = i % 500 == 0 ? 0.02 + 0.02 * any(random) : reference;
    measured += 0.01 * (reference - measured) + 1e-5 * any(random);
    const S wanted_W = Pid<S>::step(q, GainScale<S>{}, S(-1), s, scalar<S>(reference),
                                    scalar<S>(measured), S(1e-3));
    const S given_W = wanted_W < S(0) ? S(0) : S(1) < wanted_W ? S(1) : wanted_W;
    Pid<S>::limited(q, s, wanted_W, given_W, S(1e-3));
    powers.push_back(static_cast<double>(wanted_W));
  }
  return powers;
}

TEST(ScaledDevice, ThePidIsThatOfADouble) {
  for (unsigned seed = 1; seed <= 50; ++seed) {
    const std::vector<double> exact = powers_W<double>(seed);
    const std::vector<double> scaled = powers_W<Scaled>(seed);
    const double max = std::abs(
        *std::ranges::max_element(exact, {}, [](double power_W) { return std::abs(power_W); }));
    for (std::size_t i = 0; i < exact.size(); ++i) {
      ASSERT_NEAR(scaled[i], exact[i], 1e-6 * max) << "seed " << seed << ", step " << i;
    }
  }
}

/// A device with its wire.
template <class S>
class Loop {
 public:
  Output<S> step(double strain) { return step(wire.inputs<S>(), strain); }
  Output<S> step(const Inputs<S>& in, double strain) {
    const Command<S> command{
        .fresh = true, .arm = true, .mode = Mode::strain, .setpoint = scalar<S>(strain)};
    const Output<S> out = Device<S>::step(prepared_, state_, in, command, S(1e-3));
    wire.advance(static_cast<double>(out.drive_current_A), 1e-3);
    return out;
  }
  TestBench wire{files::load_wire("smartflex-76um").wire, 150e6};

 private:
  Prepared<S> prepared_ = prepare(test_settings<S>());
  typename Device<S>::State state_ = Device<S>::start();
};

/// Only the last 100 steps of each set-point are compared, when the wire is held. Times are sums of
/// steps: by rounding, one may end a step earlier, which shifts all that follows.
TEST(ScaledDevice, HoldsAWireWhereADoubleDoes) {
  Loop<double> exact;
  Loop<Scaled> scaled;
  const double longest = exact.wire.strain();
  for (const double contraction : {0.01, 0.03, 0.02, 0.035, 0.005, 0.025}) {
    for (int i = 0; i < 600; ++i) {
      const Output<double> a = exact.step(longest - contraction);
      const Output<Scaled> b = scaled.step(longest - contraction);
      ASSERT_TRUE(b.latched.empty());
      ASSERT_TRUE(isfinite(b.drive_current_A + b.estimate.strain_sd + b.hot_spot_K));
      if (i >= 500) {
        ASSERT_EQ(b.state, DeviceState::running);
        EXPECT_NEAR(scaled.wire.strain(), exact.wire.strain(), 4e-7);
        EXPECT_NEAR(static_cast<double>(b.estimate.strain), a.estimate.strain, 4e-7);
      }
    }
  }
}

TEST(ScaledDevice, AnEmergencyStopEndsHeat) {
  Loop<Scaled> loop;
  const double longest = loop.wire.strain();
  for (int i = 0; i < 1000; ++i) {
    loop.step(longest - 0.02);
  }
  EXPECT_GT(static_cast<double>(loop.step(longest - 0.02).drive_current_A), 0.012);
  Inputs<Scaled> in = loop.wire.inputs<Scaled>();
  in.emergency_stop = true;
  EXPECT_EQ(loop.step(in, longest - 0.02).drive_current_A, Scaled(0));
}

}  // namespace
}  // namespace smaservo::scaled_device_test
