#pragma once
// A device as a node on the bus. Everything from one thread; nothing waits.
//
//   Servo<float> servo(config, staging);
//   servo.start(image, now);
//   forever: receive() each frame; advance(); send what take() gives; answer request();
//            step the device with command() and external(); publish() what came of it;
//            when settings_changes() has counted, adopt() staging.active() between two steps
//
// Requests (Node::request()): store and restore are answered by finish(), when it is durable; a
// reset by start() with the stored image, after the heat is off. Before a start() for reset_node
// the main may put other settings into the Staging. The wire is heated only while command().arm is
// set.

#include <cmath>

#include "firmware/canopen/servo/servo_core.hpp"
#include "firmware/canopen/servo/tuning.hpp"
#include "firmware/command.hpp"

namespace smaservo::canopen {

namespace detail {

/// Constructed before the core that refers to it.
template <class S>
struct OwnTuning {
  explicit OwnTuning(Staging<S>& staging) : tuning(staging) {}
  Tuning<S> tuning;
};

template <class S>
ServoConfig with_identity(ServoConfig config, const Settings<S>& settings) {
  config.node.device_type = servo_device_type;
  config.node.identity = {0, servo_product, servo_revision, settings.identity.serial_number};
  config.node.node_id = static_cast<std::uint8_t>(settings.identity.node_id);
  config.step_s = static_cast<float>(settings.timing.period_s);
  return config;
}

}  // namespace detail

template <class S>
class Servo final : private detail::OwnTuning<S>, private ServoCore {
 public:
  /// Both outlive the servo.
  Servo(const ServoConfig& config, Staging<S>& staging)
      : detail::OwnTuning<S>(staging),
        ServoCore(detail::with_identity(config, staging.active()), this->tuning),
        staging_(staging) {}

  /// After switching on, and as the answer to a reset. False: the image is damaged, defaults hold.
  bool start(std::span<const std::uint8_t> image, std::uint64_t now_us) {
    return node().start(image, now_us);
  }
  void receive(const CanFrame& frame, std::uint64_t now_us) { node().receive(frame, now_us); }
  /// At least every millisecond.
  using ServoCore::advance;
  bool take(CanFrame& frame) { return node().take(frame); }

  /// For the next step.
  Command<S> command() const;
  using ServoCore::external;
  using ServoCore::setpoints;
  /// What the step came to, and what it was made from. Once per step.
  void publish(const Output<S>& output, const Inputs<S>& inputs, const S& dt_s);
  using ServoCore::set_bus;
  /// The bus is off, by the port: EMCY code 8140h. What 6007h says follows.
  using ServoCore::connection_lost;
  using ServoCore::hold_settings;
  using ServoCore::set_timing;

  const Settings<S>& settings() const { return staging_.active(); }
  std::uint32_t settings_changes() const { return this->tuning.changes(); }
  /// The main has put other settings in force by itself; a tuning transaction is over.
  void replace_settings(const Settings<S>& settings) { this->tuning.replace(settings); }

  Request request() const { return node().request(); }
  void finish(bool done) { node().finish(done); }
  /// What 1010h stores beside the settings (Staging::configured()): at most Node::image_size bytes.
  std::size_t image(std::span<std::uint8_t> to) const { return node().image(to); }
  using ServoCore::take_change;

  using ServoCore::axis;
  using ServoCore::node;
  using ServoCore::objects;

 private:
  Staging<S>& staging_;
  float position_m_ = 0, velocity_m_s_ = 0;
  bool has_position_ = false;
};

template <class S>
Command<S> Servo<S>::command() const {
  const AxisDemand demand = this->demand();
  Command<S> c;
  c.fresh = is_fresh();
  c.arm = demand.arm;
  c.clear_faults = demand.clear;
  c.mode = demand.mode;
  c.setpoint = S(demand.setpoint);
  return c;
}

template <class S>
void Servo<S>::publish(const Output<S>& out, const Inputs<S>& in, const S& dt_s) {
  const auto f = [](const S& x) { return static_cast<float>(x); };
  const Settings<S>& q = staging_.active();
  const auto dt = f(dt_s);
  const float position_m = f((q.axis.zero_strain - out.estimate.strain) * q.wire.geometry.length_m);
  constexpr float filter_s = 0.02F;
  if (has_position_) {
    const float raw_m_s = (position_m - position_m_) / dt;
    velocity_m_s_ += dt / (dt + filter_s) * (raw_m_s - velocity_m_s_);
  }
  has_position_ = std::isfinite(position_m);
  velocity_m_s_ = has_position_ ? velocity_m_s_ : 0;
  position_m_ = position_m;

  StepReport report{};
  Signals& s = report.signals;
  of(s, Signal::strain) = f(out.estimate.strain);
  of(s, Signal::strain_sd) = f(out.estimate.strain_sd);
  of(s, Signal::temperature_K) = f(out.estimate.temperature_K);
  of(s, Signal::martensite) = f(out.estimate.martensite);
  of(s, Signal::r_phase) = f(out.estimate.r_phase);
  of(s, Signal::resistance_ohm) = f(out.measurement.resistance_ohm);
  of(s, Signal::resistance_model_ohm) = f(out.estimate.resistance_model_ohm);
  of(s, Signal::stress_Pa) = f(out.measurement.stress_Pa);
  of(s, Signal::power_W) = f(out.measurement.power_W);
  of(s, Signal::current_A) = f(out.current_A);
  of(s, Signal::voltage_V) = f(out.voltage_V);
  of(s, Signal::setpoint) = f(out.setpoint);
  of(s, Signal::reference) = f(out.reference);
  of(s, Signal::wanted_power_W) = f(out.power_W);
  of(s, Signal::ambient_K) = f(out.ambient_K);
  of(s, Signal::hot_spot_K) = f(out.hot_spot_K);
  of(s, Signal::position_m) = position_m;
  of(s, Signal::velocity_m_s) = velocity_m_s_;
  of(s, Signal::force_N) = f(out.measurement.stress_Pa * q.wire.geometry.area_m2());
  of(s, Signal::measured_A) = f(in.sample.current_A);
  of(s, Signal::measured_V) = f(in.sample.voltage_V);
  of(s, Signal::supply_V) = f(in.supply_V);
  of(s, Signal::limit_reasons) = static_cast<float>(out.limit_reasons);
  report.state = out.state;
  report.latched = out.latched;
  report.active = out.active;
  report.warnings = out.warnings;
  report.blocks = out.blocks;
  report.first_cause = out.first_cause;
  report.limit_reasons = out.limit_reasons;
  report.dt_s = dt;
  ServoCore::publish(report);
}

}  // namespace smaservo::canopen
