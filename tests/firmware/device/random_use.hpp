#pragma once
// A device in random use, closed on a lumped wire: commands of all modes, readings that are wrong
// for a while in every way that a board knows, faults that are cleared and armed again. Everything
// lasts long enough for what follows from it.

#include <array>
#include <cmath>
#include <random>

#include "tests/firmware/device/test_device.hpp"

namespace smaservo {

template <class S>
class RandomUse {
 public:
  explicit RandomUse(std::uint64_t seed) : random_(seed), wire_(preset(), 150e6) { rest(); }

  /// The next instant, after what the device said last.
  void next(const Output<S>& last) {
    wire_.advance(disturbed_A(static_cast<double>(last.drive_current_A)),
                  static_cast<double>(dt_s));
    if (!std::isfinite(wire_.temperature_K()) || 900 < wire_.temperature_K()) {
      rest();  // burnt: a new wire
    }
    choose_command(last);
    idle_steps_ = is_heated(last.state) ? 0 : idle_steps_ + 1;
    if (trouble_steps_ > 0) {
      --trouble_steps_;
    } else if (chance(0.0015)) {
      trouble_ = static_cast<Trouble>(below(static_cast<std::uint32_t>(Trouble::count)));
      trouble_steps_ = 1 + below(chance(0.2) ? 1500 : 60);
      if (trouble_ == Trouble::silence) {
        trouble_steps_ += 150;  // beyond the command's time-out
      }
    }
    inputs = read();
    if (trouble_steps_ > 0) {
      disturb();
    }
  }
  /// Switched off and on: another load, air and cycle time, and a wire that has cooled.
  void rest() {
    wire_ = TestBench(preset(), 1e6 * (20 + uniform() * 300), 278.15 + 30 * uniform());
    longest_ = wire_.strain();
    dt_s = S(chance(0.8) ? 1e-3 : 2e-4 + uniform() * 5e-3);
    command = {};
    trouble_steps_ = 0;
    idle_steps_ = 0;
  }

  /// Whether the device could not be armed for long. Some faults last until it is switched off and
  /// on.
  bool idle() const { return 1500 < idle_steps_; }

  double uniform() { return static_cast<double>(random_() >> 11U) * 0x1p-53; }
  bool chance(double p) { return uniform() < p; }
  std::uint32_t below(std::uint32_t n) { return static_cast<std::uint32_t>(random_() % n); }

  Inputs<S> inputs{};
  Command<S> command{};
  S dt_s = S(1e-3);

 private:
  enum class Trouble : std::uint8_t {
    // troubles between the drive and the wire
    open,
    less_current,
    more_current,
    lasting_current,
    // troubles of readings and commands
    voltage,
    current,
    load,
    shorted,
    less_voltage,
    low_gains,
    noise,
    stale,
    emergency_stop,
    driver,
    late,
    bus,
    silence,
    frozen,
    setpoint,
    supply,
    driver_heat,
    ambient_sensor,
    // changes of the surroundings, which stay
    stress,
    ambient,
    count
  };
  static constexpr S nan = std::numeric_limits<S>::quiet_NaN();
  static constexpr S inf = std::numeric_limits<S>::infinity();

  static const Wire<double>& preset() {
    static const Wire<double> wire = files::load_wire("smartflex-76um").wire;
    return wire;
  }
  S between(double a, double b) { return static_cast<S>(a + (b - a) * uniform()); }

  void choose_command(const Output<S>& last) {
    command.fresh = true;
    command.clear_faults = last.first_cause != Fault::none && chance(0.02);
    // The command to arm falls now and then, and rises again soon.
    command.arm = command.arm ? !chance(is_heated(last.state) ? 0.0003 : 0.02) : chance(0.05);
    if (chance(0.004)) {
      command.mode = static_cast<Mode>(below(mode_count));
      command.setpoint = setpoint(command.mode);
      command.scale = {between(0, 3), between(0, 3), between(0, 3)};
    } else if (chance(0.002)) {
      command.setpoint = setpoint(command.mode);
    }
  }
  /// A set-point that is mostly sensible, at times beyond every limit.
  S setpoint(Mode mode) {
    const double wide = chance(0.1) ? 3 : 1;
    switch (mode) {
      case Mode::current:
        return between(0, 0.4 * wide);
      case Mode::power:
        return between(0, 3 * wide);
      case Mode::resistance:
        return static_cast<S>(wire_.resistance_ohm()) * between(0.9, 1.05 * wide);
      case Mode::temperature:
        return between(300, 420 * wide);
      case Mode::strain:
        return static_cast<S>(longest_) - between(0, 0.045 * wide);
      case Mode::position:
        return between(0, 0.04 * wide) * S(0.1);
      case Mode::force:
        return between(0, 2 * wide);
      case Mode::off:
      case Mode::identification:
        break;
    }
    return S(0);
  }

  Inputs<S> read() {
    Inputs<S> in = wire_.inputs<S>();
    in.sample.current_A += between(-3e-5, 3e-5);
    in.sample.voltage_V += between(-1e-3, 1e-3);
    in.driver_K = S(313);
    return in;
  }
  double disturbed_A(double given_A) const {
    if (trouble_steps_ == 0) {
      return given_A;
    }
    switch (trouble_) {
      case Trouble::open:
        return 0;
      case Trouble::less_current:
        return 0.5 * given_A;
      case Trouble::more_current:
        return given_A > 0 ? 0.5 : 0;
      case Trouble::lasting_current:
        return 0.05;
      default:
        return given_A;
    }
  }
  void disturb() {
    disturb_sample(inputs.sample);
    disturb_signals();
    if (trouble_ == Trouble::stress || trouble_ == Trouble::ambient) {
      trouble_steps_ = 0;
    }
    if (trouble_ == Trouble::stress) {
      wire_.stress(1e6 * (0.2 + 600 * uniform()));
    } else if (trouble_ == Trouble::ambient) {
      wire_.ambient(260 + 80 * uniform());
    }
  }
  S anything() {
    constexpr std::array<S, 6> wrong = {nan, inf, -inf, S(1e30), S(-1e30), S(0)};
    return wrong[below(wrong.size())];
  }
  void disturb_sample(Sample<S>& sample) {
    switch (trouble_) {
      case Trouble::open:
        sample.voltage_V = S(20);
        break;
      case Trouble::voltage:
        sample.voltage_V = anything();
        break;
      case Trouble::current:
        sample.current_A = anything();
        break;
      case Trouble::load:
        sample.load_N = anything();
        break;
      case Trouble::shorted:
        sample.voltage_V *= S(0.3);
        break;
      case Trouble::less_voltage:
        sample.voltage_V *= S(0.85);
        break;
      case Trouble::low_gains:
        sample.current_A *= S(0.87);
        sample.voltage_V *= S(0.87);
        break;
      case Trouble::noise:
        sample = {between(-1, 1), between(-20, 20), between(-1, 3)};
        break;
      default:
        break;
    }
  }
  void disturb_signals() {
    inputs.fresh = trouble_ != Trouble::stale;
    inputs.emergency_stop = trouble_ == Trouble::emergency_stop;
    inputs.driver_fault = trouble_ == Trouble::driver;
    inputs.deadline_missed = trouble_ == Trouble::late;
    inputs.external.add(Fault::bus_lost, trouble_ == Trouble::bus);
    command.fresh = trouble_ != Trouble::silence;
    switch (trouble_) {
      case Trouble::frozen:
        inputs.sequence = 7;
        break;
      case Trouble::setpoint:
        command.setpoint = anything();
        break;
      case Trouble::supply:
        inputs.supply_V = chance(0.5) ? anything() : between(2, 40);
        break;
      case Trouble::driver_heat:
        inputs.driver_K = chance(0.5) ? anything() : between(340, 370);
        break;
      case Trouble::ambient_sensor:
        inputs.ambient_K = anything();
        break;
      default:
        break;
    }
  }

  std::mt19937_64 random_;
  TestBench wire_;
  double longest_ = 0;
  Trouble trouble_ = Trouble::open;
  std::uint32_t trouble_steps_ = 0;
  std::uint32_t idle_steps_ = 0;
};

}  // namespace smaservo
