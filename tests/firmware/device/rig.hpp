#pragma once
// A device that drives a wire which is not its model, behind noisy sensors, with places where a
// fault can be put in.

#include <functional>
#include <memory>
#include <random>
#include <utility>

#include "firmware/device/device.hpp"
#include "model/wire/distributed.hpp"
#include "tests/firmware/device/test_device.hpp"

namespace smaservo {

/// How a wire and its surroundings differ from what the settings say.
struct Unlike {
  double ambient_K = room_K;
  double loss = 1;        ///< factor
  double resistance = 1;  ///< factor
  double shift_K = 0;     ///< shift of all transformations
};

inline Unlike random_unlike(std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  Unlike u;
  u.ambient_K += 2 * normal(random);
  u.loss += 0.07 * normal(random);
  u.resistance += 0.003 * normal(random);
  u.shift_K = normal(random);
  return u;
}

/// The wire itself.
class RigWire {
 public:
  RigWire() = default;
  RigWire(const RigWire&) = delete;
  RigWire& operator=(const RigWire&) = delete;
  virtual ~RigWire() = default;
  virtual void advance(double current_A, double stress_Pa, double draught, double dt_s) = 0;
  virtual double strain() const = 0;
  virtual double resistance_ohm() const = 0;
  virtual double hottest_K() const = 0;
};

class LumpedRigWire : public RigWire {
 public:
  using Model = Plant<ThreePhase<double>>;
  LumpedRigWire(const Wire<double>& wire, const Unlike& unlike, double stress_Pa)
      : unlike_(unlike), params_(plant_params(wire)) {
    auto& k = params_.kinetics;
    k.smallest_reversal_K = 0;
    k.m2a.start_K[0] += unlike.shift_K;
    k.m2a.finish_K[0] += unlike.shift_K;
    k.a2m_a2r.start_K[0] += Pair<double>(unlike.shift_K);
    k.a2m_a2r.finish_K[0] += Pair<double>(unlike.shift_K);
    state_ = Model::rest(params_, {unlike.ambient_K, stress_Pa});
  }
  void advance(double current_A, double stress_Pa, double draught, double dt_s) final {
    Model::Params p = params_;
    p.body.loss_W_K *= unlike_.loss * draught;
    p.body.loss_W_K2 *= unlike_.loss * draught;
    Model::advance(p, state_,
                   {current_A * current_A * resistance_ohm(), stress_Pa, unlike_.ambient_K}, dt_s);
  }
  double strain() const final { return Model::strain(params_, state_); }
  double resistance_ohm() const final {
    return unlike_.resistance * Model::resistance_ohm(params_, state_, unlike_.ambient_K);
  }
  double hottest_K() const final { return Model::temperature_K(state_); }

 private:
  Unlike unlike_;
  Model::Params params_;
  Model::State state_{};
};

/// A wire with cold clamps, conduction along it, and transition temperatures that scatter along it.
class DistributedRigWire : public RigWire {
 public:
  static constexpr std::size_t segments = 12;
  using Model = DistributedPlant<ThreePhase<double>, segments>;
  DistributedRigWire(const Wire<double>& wire, const Unlike& unlike, double stress_Pa,
                     std::mt19937_64& random)
      : unlike_(unlike) {
    params_.material = wire.material;
    params_.heat = wire.heat;
    params_.geometry = wire.geometry;
    std::normal_distribution<double> normal;
    double sum = 0;
    for (std::size_t i = 0; i < segments; ++i) {
      params_.length_m[i] = std::pow(2, static_cast<double>(std::min(i, segments - 1 - i)));
      sum += params_.length_m[i];
    }
    for (std::size_t i = 0; i < segments; ++i) {
      params_.length_m[i] *= wire.geometry.length_m / sum;
      auto& k = params_.kinetics[i];
      k = wire.kinetics;
      k.smallest_reversal_K = 0;
      const double shift_K = unlike.shift_K + normal(random);
      k.m2a.start_K[0] += shift_K;
      k.m2a.finish_K[0] += shift_K;
      k.a2m_a2r.start_K[0] += Pair<double>(shift_K);
      k.a2m_a2r.finish_K[0] += Pair<double>(shift_K);
    }
    state_ = Model::rest(params_, {unlike.ambient_K, stress_Pa});
  }
  void advance(double current_A, double stress_Pa, double draught, double dt_s) final {
    Model::advance(params_, state_, current_A, {stress_Pa, unlike_.ambient_K},
                   unlike_.loss * draught, dt_s);
  }
  double strain() const final { return Model::strain(params_, state_); }
  double resistance_ohm() const final {
    return unlike_.resistance * Model::resistance_ohm(params_, state_);
  }
  double hottest_K() const final {
    double hottest = 0;
    for (std::size_t i = 0; i < segments; ++i) {
      hottest = std::max(hottest, Model::temperature_K(state_, i));
    }
    return hottest;
  }

 private:
  Unlike unlike_;
  Model::Params params_{};
  Model::State state_{};
};

/// Device, wire, sensors and surroundings; one step of 1 ms at a time.
class Rig {
 public:
  static constexpr double dt_s = 1e-3;

  Rig(const Settings<double>& with, std::unique_ptr<RigWire> driven, double load_Pa,
      std::uint64_t seed = 1)
      : settings(with),
        prepared(prepare(with)),
        wire(std::move(driven)),
        stress_Pa(load_Pa),
        random_(seed) {
    command.fresh = true;
  }

  const Output<double>& step() {
    inputs = read();
    if (tamper_inputs) {
      tamper_inputs(inputs);
    }
    if (tamper_command) {
      tamper_command(command);
    }
    const double step_s = dt_s + std::exchange(stalled_s_, 0);
    const Measurement<double> m = Device<double>::observe(prepared, state, inputs, step_s);
    Estimate<double> e = Device<double>::estimate(prepared, state);
    if (tamper_estimate) {
      tamper_estimate(e);
    }
    out = Device<double>::decide(prepared, state, inputs, m, e, command, step_s);
    flowing_A = tamper_drive ? tamper_drive(out.drive_current_A) : out.drive_current_A;
    wire->advance(flowing_A, stress_Pa, draught, dt_s);
    hottest_K = std::max(hottest_K, wire->hottest_K());
    ++steps;
    return out;
  }
  void run(double time_s) {
    const auto n = static_cast<int>(std::lround(time_s / dt_s));
    for (int i = 0; i < n; ++i) {
      step();
    }
  }
  /// The loop stands still for so long before the next step. The output persists, and may be
  /// cut off at the end.
  void stall(double time_s, bool cut = false) {
    const auto n = static_cast<int>(std::lround(time_s / dt_s));
    for (int i = 0; i < n; ++i) {
      wire->advance(flowing_A, stress_Pa, draught, dt_s);
    }
    hottest_K = std::max(hottest_K, wire->hottest_K());
    flowing_A = cut ? 0 : flowing_A;
    stalled_s_ = time_s;
  }
  /// From switching on into running, in this mode.
  void arm(Mode mode, double setpoint) {
    command.arm = true;
    command.mode = mode;
    command.setpoint = setpoint;
    run(0.22);
  }

  double load_N() const { return stress_Pa * settings.wire.geometry.area_m2(); }

  Settings<double> settings;
  Prepared<double> prepared;
  std::unique_ptr<RigWire> wire;
  Device<double>::State state = Device<double>::start();
  Command<double> command;
  Inputs<double> inputs{};
  Output<double> out{};
  double stress_Pa;
  double draught = 1;
  double supply_V = 24;
  double flowing_A = 0;  ///< through the wire
  double hottest_K = 0;  ///< highest temperature so far
  int steps = 0;
  // Where faults come in.
  /// Gives the current that flows for a current that is commanded.
  std::function<double(double)> tamper_drive;
  std::function<void(Inputs<double>&)> tamper_inputs;
  std::function<void(Command<double>&)> tamper_command;
  std::function<void(Estimate<double>&)> tamper_estimate;

 private:
  Inputs<double> read() {
    const MeasurementSettings<double>& q = settings.measurement;
    const double I_noise = q.current_noise_A * normal_(random_);
    const double V_noise = q.voltage_noise_V * normal_(random_);
    const double load_noise_Pa = 0.3e6 * normal_(random_);
    Inputs<double> in{};
    in.fresh = true;
    in.sequence = sequence_++;
    in.sample = {quantised(flowing_A + I_noise, q.current_full_scale_A),
                 quantised(flowing_A * wire->resistance_ohm() + V_noise, q.voltage_full_scale_V),
                 load_N() + load_noise_Pa * settings.wire.geometry.area_m2()};
    in.supply_V = supply_V;
    in.ambient_K = std::numeric_limits<double>::quiet_NaN();
    in.driver_K = 313.15;
    return in;
  }
  static double quantised(double value, double full_scale) {
    const double step = full_scale / 32768;
    return std::clamp(std::round(value / step) * step, -full_scale, full_scale - step);
  }

  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
  std::uint32_t sequence_ = 0;
  double stalled_s_ = 0;
};

/// A rig whose wire is as its settings say, except for noise.
inline Rig plain_rig(const Settings<double>& settings = test_settings(), double load_Pa = 150e6) {
  return {settings, std::make_unique<LumpedRigWire>(settings.wire, Unlike{}, load_Pa), load_Pa};
}

}  // namespace smaservo
