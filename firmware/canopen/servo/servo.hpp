#pragma once
// A device as a node on the bus. All calls come from one thread; none of them blocks.
//
//   Servo<float> servo(config, staging);
//   servo.start(image, now);
//   forever: receive() each frame; advance(); send the frames of take(); answer request();
//            step the device with command() and external(); publish() its result;
//            when the owner of the settings has others, adopt() them between two steps
//
// Requests (Node::request()): store and restore are answered by finish() with the request's number
// when the result is durable; a reset is answered by start() with the stored image, after the heat
// is off. Before a start() for reset_node the main program may restart() the Staging with others.
// The wire is heated only while command().arm is set.

#include <cmath>

#include "firmware/canopen/servo/servo_core.hpp"
#include "firmware/canopen/servo/tuning.hpp"
#include "firmware/command.hpp"

namespace smaservo::canopen {

namespace detail {

/// A base class, so that it is constructed before the core that refers to it.
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
  /// `staging`, and the memory that `config` refers to, must outlive the servo.
  Servo(const ServoConfig& config, Staging<S>& staging)
      : detail::OwnTuning<S>(staging),
        ServoCore(detail::with_identity(config, staging.active()), this->tuning),
        staging_(staging) {}

  /// To be called after switching on, and as the answer to a reset. False if the image is damaged;
  /// the defaults are then used.
  bool start(std::span<const std::uint8_t> image, std::uint64_t now_us) {
    return node().start(image, now_us);
  }
  void receive(const hal::CanFrame& frame, std::uint64_t now_us) { node().receive(frame, now_us); }
  /// To be called at least every millisecond.
  using ServoCore::advance;
  bool take(hal::CanFrame& frame) { return node().take(frame); }

  /// The command for the next step.
  Command<S> command() const;
  using ServoCore::external;
  using ServoCore::setpoints;
  /// Takes the result of a step and its inputs. To be called once per step.
  void publish(const Output<S>& output, const Inputs<S>& inputs, const S& dt_s);
  using ServoCore::set_bus;
  /// To be called with EMCY code 8140h when the port reports bus off; 6007h says what follows.
  using ServoCore::connection_lost;
  using ServoCore::set_timing;

  const Settings<S>& settings() const { return staging_.active(); }
  /// To be called when the settings have been changed other than over the bus; they must have
  /// passed check(). Ends a tuning transaction; each parameter that changes is logged like a write.
  void replace_settings(const Settings<S>& settings, Source source);
  using ServoCore::note_change;

  Request request() const { return node().request(); }
  std::uint32_t request_number() const { return node().request_number(); }
  void finish(std::uint32_t number, bool done) { node().finish(number, done); }
  /// The bytes that 1010h stores besides the settings (Staging::configured()): at most
  /// Node::image_size.
  std::size_t image(std::span<std::uint8_t> to) const { return node().image(to); }
  using ServoCore::take_change;

  using ServoCore::axis;
  using ServoCore::node;
  using ServoCore::objects;

 private:
  /// Computes position, its filtered rate, and force.
  Motion advance_motion(const Output<S>& out, float dt_s);

  Staging<S>& staging_;
  Motion motion_{};
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
void Servo<S>::replace_settings(const Settings<S>& settings, Source source) {
  log_revert(Source::device);
  const Settings<S> before = staging_.configured();
  this->tuning.replace(settings);
  for (const ParameterRow<S>& row : parameter_rows<S>) {
    const Value was = row.get(before);
    const Value is = row.get(staging_.configured());
    if (was != is) {
      note_change(row.key, was.bits, is.bits, source);
    }
  }
}

template <class S>
void Servo<S>::publish(const Output<S>& out, const Inputs<S>& in, const S& dt_s) {
  StepReport report{};
  report.dt_s = static_cast<float>(dt_s);
  report.signals = read_signals<S>({out, in, advance_motion(out, report.dt_s)});
  report.state = out.state;
  report.latched = out.latched;
  report.active = out.active;
  report.warnings = out.warnings;
  report.told_count = out.told_count;
  report.blocks = out.blocks;
  report.first_cause = out.first_cause;
  report.limit_reasons = out.limit_reasons;
  ServoCore::publish(report);
}

template <class S>
Motion Servo<S>::advance_motion(const Output<S>& out, float dt_s) {
  const Settings<S>& q = staging_.active();
  const auto position_m =
      static_cast<float>((q.axis.zero_strain - out.estimate.strain) * q.wire.geometry.length_m);
  constexpr float filter_s = 0.02F;
  if (has_position_) {
    const float raw_m_s = (position_m - motion_.position_m) / dt_s;
    motion_.velocity_m_s += dt_s / (dt_s + filter_s) * (raw_m_s - motion_.velocity_m_s);
  }
  has_position_ = std::isfinite(position_m);
  motion_.velocity_m_s = has_position_ ? motion_.velocity_m_s : 0;
  motion_.position_m = position_m;
  const auto area_m2 = q.wire.geometry.area_m2();
  motion_.force_N = static_cast<float>(out.stress_Pa() * area_m2);
  motion_.load_estimate_N = static_cast<float>(out.wire_stress_Pa * area_m2);
  return motion_;
}

}  // namespace smaservo::canopen
