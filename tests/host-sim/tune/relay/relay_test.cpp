#include "host-sim/tune/relay/relay.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <numbers>

#include "model/files/wire/wire_file.hpp"

namespace smaservo::tune {
namespace {

/// y' = k P, exactly.
RelayPlant relayed_integrator(double k, double period_s) {
  double y = 0;
  return {[=](double power_W) mutable { return y += k * power_W * period_s; }, 0};
}

/// A triangle between switches: a quarter of the period is hysteresis and delay. The fundamental of
/// an integral is k/w by theory, whatever its shape.
TEST(Relay, MakesATriangleOfAnIntegrator) {
  const double period_s = 1e-3, k = 3, h = 0.2;
  for (const int delay : {0, 1, 3}) {
    RelayTask t{period_s, delay, 0, 0, h, 0, 1, 0};
    t.hysteresis = (20.5 - delay) * h * k * period_s;
    const Oscillation o = relay_test(t, relayed_integrator(k, period_s));
    EXPECT_TRUE(o.steady);
    EXPECT_NEAR(2 * std::numbers::pi / o.rad_s, 4 * 21 * period_s, 4 * period_s);
    EXPECT_NEAR(o.gain, k / o.rad_s, 0.01 * o.gain);
  }
}

TEST(Relay, ExpectsWhatItsDescribingFunctionSays) {
  const LinearLoop loop{1e-3, 1, 0.02, 1e-6, 5, 0, 0, 0, {}};
  RelayTask t{1e-3, 1, 0, 0, 0.3, 0, 1, 0};
  t.hysteresis = 0.3 * 250 * 20e-3;
  const Oscillation e = expected_oscillation(loop, t);
  // L = k/(jw) e^(-jwd): its imaginary part -k cos(w d)/w is -pi eps/(4 h).
  const double k = loop.by_kelvin / loop.capacity_J_K;
  EXPECT_NEAR(k * std::cos(e.rad_s * 1.5e-3) / e.rad_s,
              std::numbers::pi * t.hysteresis / (4 * t.amplitude_W), 1e-3 * e.gain);
  EXPECT_NEAR(e.gain, k / e.rad_s, 1e-3 * e.gain);
}

TEST(Relay, DoesNotCallSteadyWhatRunsAway) {
  const RelayTask t{1e-3, 1, 1, 0, 0.2, 0, 1, 0.01};
  EXPECT_FALSE(relay_test(t, relayed_integrator(3, 1e-3)).steady)
      << "the base power is not balanced";
}

/// The linearisation is right: a relay on the whole wire finds its frequency and gain.
TEST(Relay, AgreesWithTheLinearisation) {
  const auto checks = [](const char* wire, const TunedLoad& load) {
    const TuneTask task{{files::load_wire(wire).wire, load, room_K, 1},
                        std::numeric_limits<double>::infinity(),
                        1,
                        1};
    return relay_checks(task, propose(task));
  };
  for (const char* wire : {"smartflex-76um", "flexinol-lt-0.10mm", "smartflex-300um"}) {
    const auto all = checks(wire, {120e6, 120e6, 0});
    EXPECT_EQ(all.size(), 8U);
    for (const RelayCheck& c : all) {
      EXPECT_TRUE(agrees(c)) << wire << ' ' << loop_text(c.name) << ' ' << motion_name(c.motion)
                             << ' ' << c.plant;
    }
  }
  const auto spring = checks("smartflex-76um", {100e6, 250e6, 0.04});
  EXPECT_EQ(spring.size(), 8U) << "of one body, the force's too";
  for (const RelayCheck& c : spring) {
    EXPECT_TRUE(agrees(c)) << loop_text(c.name) << ' ' << motion_name(c.motion);
  }
}

}  // namespace
}  // namespace smaservo::tune
