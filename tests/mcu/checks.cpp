#include "tests/mcu/checks.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "firmware/device/device.hpp"
#include "firmware/parameters/store/store.hpp"

namespace smaservo::mcu {
namespace {

using S = float;
using Model = ThreePhase<S>;
using Wired = Plant<Model>;

constexpr S air_K = static_cast<S>(room_K);
constexpr S load_Pa = 150e6F;

/// The same numbers on every machine.
class Dice {
 public:
  S between(S low, S high) {
    bits_ = bits_ * 1664525U + 1013904223U;
    return low + (high - low) * static_cast<S>(bits_ >> 8U) * 0x1p-24F;
  }

 private:
  std::uint32_t bits_ = 20260102;
};

S difference(const Model::State& a, const Model::State& b) {
  const Phases<S> x = Model::phases(a);
  const Phases<S> y = Model::phases(b);
  return std::max({std::abs(x.martensite - y.martensite), std::abs(x.r_phase - y.r_phase)});
}

void ramp(const Model::Params& p, Model::State& s, S to_K, S stress_Pa, int steps) {
  const S from_K = Model::drive(s).temperature_K;
  for (int i = 1; i <= steps; ++i) {
    const S share = static_cast<S>(i) / static_cast<S>(steps);
    Model::advance(p, s, {from_K + share * (to_K - from_K), stress_Pa});
  }
}

void fractions_are_fractions(const Settings<S>& settings, Verdict& verdict) {
  Dice dice;
  Model::State s = Model::rest(settings.wire.kinetics, {air_K, load_Pa});
  for (int i = 0; i < 3000; ++i) {
    Model::advance(settings.wire.kinetics, s, {dice.between(250, 450), dice.between(0, 400e6F)});
    const Phases<S> z = Model::phases(s);
    verdict.expect(0 <= z.martensite && 0 <= z.r_phase && -1e-6F <= z.austenite(),
                   "a fraction is negative");
    verdict.expect(z.martensite + z.r_phase <= 1 + 1e-6F, "fractions are more than all");
  }
}

void standing_still_does_nothing(const Settings<S>& settings, Verdict& verdict) {
  Dice dice;
  Model::State s = Model::rest(settings.wire.kinetics, {air_K, load_Pa});
  for (int i = 0; i < 1000; ++i) {
    const Drive<S> u{dice.between(280, 420), dice.between(50e6F, 300e6F)};
    Model::advance(settings.wire.kinetics, s, u);
    const Model::State before = s;
    Model::advance(settings.wire.kinetics, s, u);
    verdict.expect(difference(before, s) == 0, "the wire moves where nothing does");
  }
}

void the_way_counts_not_the_steps(const Settings<S>& settings, Verdict& verdict) {
  const Model::Params& p = settings.wire.kinetics;
  Model::State one = Model::rest(p, {air_K, load_Pa});
  Model::State many = one;
  for (const S to_K : {350.F, 335.F, 360.F, 420.F, 330.F, 345.F, 310.F, 280.F}) {
    ramp(p, one, to_K, load_Pa, 1);
    ramp(p, many, to_K, load_Pa, 200);
    verdict.expect(difference(one, many) < 1e-3F, "one step differs from many");
  }
}

void a_full_cycle_forgets(const Settings<S>& settings, Verdict& verdict) {
  const Model::Params& p = settings.wire.kinetics;
  Dice dice;
  Model::State clean = Model::rest(p, {air_K, load_Pa});
  Model::State used = clean;
  for (int i = 0; i < 100; ++i) {
    ramp(p, used, dice.between(290, 400), load_Pa, 3);
  }
  for (const S to_K : {480.F, 240.F}) {
    ramp(p, clean, to_K, load_Pa, 50);
    ramp(p, used, to_K, load_Pa, 50);
  }
  verdict.expect(difference(clean, used) < 1e-4F, "a full cycle leaves a trace of what was before");
}

/// A wire of one temperature and its readings.
class SimpleWire {
 public:
  explicit SimpleWire(const Settings<S>& settings)
      : params_(plant_params(settings.wire)),
        state_(Wired::rest(params_, {air_K, load_Pa})),
        load_N_(load_Pa * settings.wire.geometry.area_m2()) {}

  Inputs<S> inputs() {
    Inputs<S> in{};
    in.fresh = true;
    in.sequence = ++sequence_;
    in.sample = {current_A_, current_A_ * Wired::resistance_ohm(params_, state_, air_K), load_N_};
    in.supply_V = 24;
    in.ambient_K = in.driver_K = std::numeric_limits<S>::quiet_NaN();
    return in;
  }
  void advance(S current_A) {
    current_A_ = current_A;
    const S power_W = current_A * current_A * Wired::resistance_ohm(params_, state_, air_K);
    Wired::advance(params_, state_, {power_W, load_Pa, air_K}, 1e-3F);
  }
  S strain() const { return Wired::strain(params_, state_); }

 private:
  Wired::Params params_;
  Wired::State state_;
  S load_N_;
  S current_A_ = 0;
  std::uint32_t sequence_ = 0;
};

void the_observer_follows(const Settings<S>& settings, Verdict& verdict) {
  static Prepared<S> p;
  static Device<S>::State s;
  p = prepare(settings);
  s = Device<S>::start();
  SimpleWire wire(settings);
  for (int i = 0; i < 3000; ++i) {
    const S share = static_cast<S>(i < 1500 ? i : 3000 - i) / 1500;
    wire.advance((0.05F + 0.6F * share) * settings.limits.current_A);
    Device<S>::observe(p, s, wire.inputs(), 1e-3F);
    const Estimate<S> e = Device<S>::estimate(p, s);
    const auto& P = s.observer.observer.filter[0].covariance;
    for (int k = 0; k < 6; ++k) {
      verdict.expect(0 <= P.at(k, k), "a variance is negative");
    }
    verdict.expect(
        i < 100 || std::abs(e.strain - wire.strain()) < 0.01F * settings.wire.nominal_stroke,
        "the estimate is 1 % of the stroke off");
  }
}

Command<S> hold(S strain) {
  return {.fresh = true, .arm = true, .mode = Mode::strain, .setpoint = strain};
}

/// The device in closed loop; calls f(output, wire) after each step.
template <class F>
void run_loop(const Settings<S>& settings, int steps, F f) {
  static Prepared<S> p;
  static Device<S>::State s;
  p = prepare(settings);
  s = Device<S>::start();
  SimpleWire wire(settings);
  const S target = wire.strain() - 0.5F * settings.wire.nominal_stroke;
  for (int i = 0; i < steps; ++i) {
    const Inputs<S> in = wire.inputs();
    f(i, in, wire, Device<S>::step(p, s, in, hold(target), 1e-3F));
    wire.advance(s.last.drive_current_A);
  }
}

void the_loop_holds_a_strain(const Settings<S>& settings, Verdict& verdict) {
  S begin = 0;
  run_loop(
      settings, 2000, [&](int i, const Inputs<S>&, const SimpleWire& wire, const Output<S>& out) {
        begin = i == 0 ? wire.strain() : begin;
        verdict.expect(0 <= out.drive_current_A && out.drive_current_A <= settings.trips.current_A,
                       "the current is out of its range");
        verdict.expect(out.latched.empty(), "there is a fault");
        const S target = begin - 0.5F * settings.wire.nominal_stroke;
        verdict.expect(
            i < 1500 || std::abs(wire.strain() - target) < 0.01F * settings.wire.nominal_stroke,
            "the strain is 1 % of the stroke off");
      });
}

void an_emergency_stop_ends_heat(const Settings<S>& settings, Verdict& verdict) {
  static Prepared<S> p;
  static Device<S>::State s;
  p = prepare(settings);
  s = Device<S>::start();
  SimpleWire wire(settings);
  const S target = wire.strain() - 0.5F * settings.wire.nominal_stroke;
  for (int i = 0; i < 1000; ++i) {
    Inputs<S> in = wire.inputs();
    const bool pressed = 800 <= i;
    in.emergency_stop = pressed;
    const Output<S> out = Device<S>::step(p, s, in, hold(target), 1e-3F);
    verdict.expect(i != 799 || 0 < out.drive_current_A, "the wire is not heated");
    verdict.expect(!pressed || out.drive_current_A == 0, "heat goes on");
    wire.advance(out.drive_current_A);
  }
}

/// Whatever a sensor says, the current is one that was allowed.
void readings_may_be_anything(const Settings<S>& settings, Verdict& verdict) {
  constexpr S nan = std::numeric_limits<S>::quiet_NaN();
  constexpr S inf = std::numeric_limits<S>::infinity();
  constexpr std::array wrong{nan, inf, -inf, 1e30F, -1e30F, 0.F};
  static Prepared<S> p;
  static Device<S>::State s;
  p = prepare(settings);
  s = Device<S>::start();
  SimpleWire wire(settings);
  Dice dice;
  for (int i = 0; i < 2000; ++i) {
    Inputs<S> in = wire.inputs();
    const auto which = static_cast<int>(dice.between(0, 60));
    const S value = wrong.at(static_cast<std::size_t>(dice.between(0, 5.99F)));
    in.sample.current_A = which == 0 ? value : in.sample.current_A;
    in.sample.voltage_V = which == 1 ? value : in.sample.voltage_V;
    in.sample.load_N = which == 2 ? value : in.sample.load_N;
    in.supply_V = which == 3 ? value : in.supply_V;
    in.fresh = which != 4;
    Command<S> command = hold(which == 5 ? value : 0.02F);
    command.clear_faults = which == 6;
    const Output<S> out = Device<S>::step(p, s, in, command, 1e-3F);
    verdict.expect(0 <= out.drive_current_A && out.drive_current_A <= settings.trips.current_A,
                   "the current is out of its range");
    wire.advance(out.drive_current_A);
  }
}

class Memory {
 public:
  bool read(unsigned slot, std::size_t offset, std::span<std::byte> to) const {
    std::copy_n(slots_.at(slot).begin() + static_cast<std::ptrdiff_t>(offset), to.size(),
                to.begin());
    return true;
  }
  bool erase(unsigned slot) {
    slots_.at(slot).fill(std::byte{0xFF});
    return true;
  }
  bool write(unsigned slot, std::size_t offset, std::span<const std::byte> from) {
    std::copy(from.begin(), from.end(),
              slots_.at(slot).begin() + static_cast<std::ptrdiff_t>(offset));
    return true;
  }
  static bool sync() { return true; }
  void damage(unsigned slot, std::size_t offset) { slots_.at(slot).at(offset) ^= std::byte{1}; }

 private:
  std::array<std::array<std::byte, 2048>, slot_count> slots_{};
};

void settings_survive(const Settings<S>& settings, Verdict& verdict) {
  static Memory memory;
  for (unsigned slot = 0; slot < slot_count; ++slot) {
    memory.erase(slot);
  }
  Settings<S> changed = settings;
  verdict.expect(save_settings(memory, changed).ok(), "the first image is not kept");
  changed.safe.hold_s = 2;
  const Saved second = save_settings(memory, changed);
  verdict.expect(second.ok(), "the second image is not kept");
  verdict.expect(load_settings<S>(memory).settings.safe.hold_s == 2,
                 "the newer image is not taken");
  memory.damage(second.slot, 100);
  const Loaded<S> loaded = load_settings<S>(memory);
  verdict.expect(
      loaded.reason == LoadReason::other_bad && loaded.settings.safe.hold_s == settings.safe.hold_s,
      "a damaged image is taken");
}

constexpr auto all = std::to_array<Check>({
    {"FractionsAreFractions", fractions_are_fractions},
    {"StandingStillDoesNothing", standing_still_does_nothing},
    {"TheWayCountsNotTheSteps", the_way_counts_not_the_steps},
    {"AFullCycleForgets", a_full_cycle_forgets},
    {"TheObserverFollows", the_observer_follows},
    {"TheLoopHoldsAStrain", the_loop_holds_a_strain},
    {"AnEmergencyStopEndsHeat", an_emergency_stop_ends_heat},
    {"ReadingsMayBeAnything", readings_may_be_anything},
    {"SettingsSurvive", settings_survive},
});

}  // namespace

std::span<const Check> checks() {
  return all;
}

}  // namespace smaservo::mcu
