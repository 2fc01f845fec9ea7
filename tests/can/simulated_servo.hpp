#pragma once
// A whole servo in virtual time: node, device, and a wire that is a little unlike its model.

#include "firmware/canopen/servo/servo.hpp"
#include "firmware/device/adopt.hpp"
#include "tests/firmware/device/rig.hpp"
#include "tests/firmware/parameters/random_settings.hpp"

namespace smaservo::test {

class SimulatedServo {
 public:
  static constexpr std::uint64_t step_us = 1000;
  static constexpr double load_Pa = 150e6;

  SimulatedServo(const Settings<double>& settings, canopen::ServoConfig config)
      : memory_(40'000),
        settings_(settings),
        servo_(filled(config), staging_),
        rig_(settings,
             std::make_unique<LumpedRigWire>(settings.wire, Unlike{.loss = 1.05}, load_Pa),
             load_Pa) {
    servo_.start({}, now_us_);
    rig_.tamper_inputs = [this](Inputs<double>& in) { in.external = servo_.external(); };
  }

  static Settings<double> usual_settings(std::uint32_t node) {
    Settings<double> settings = reference_settings();
    settings.identity.node_id = node;
    settings.identity.serial_number = 1000 + node;
    settings.limits.current_A = 0.4;
    settings.trips.current_A = 0.6;
    settings.measurement.current_full_scale_A = 1;
    settings.trips.stress_Pa = 300e6;
    settings.limits.stress_Pa = 250e6;
    settings.axis.zero_strain = 0.04;
    return settings;
  }

  /// One millisecond.
  void step() {
    now_us_ += step_us;
    servo_.advance(now_us_);
    if (settings_.changes() != changes_) {
      changes_ = settings_.changes();
      adopt(rig_.prepared, staging_.active(), rig_.state);
    }
    rig_.command = servo_.command();
    const Output<double>& out = rig_.step();
    servo_.publish(out, rig_.inputs, Rig::dt_s);
    const auto steps = static_cast<std::uint32_t>(rig_.steps);
    servo_.set_timing({steps, 0, 0, 0, 0, 0});
    answer_requests();
  }
  void receive(const hal::CanFrame& frame) { servo_.receive(frame, now_us_); }
  bool take(hal::CanFrame& frame) { return servo_.take(frame); }
  std::uint64_t now_us() const { return now_us_; }

  Rig& rig() { return rig_; }
  canopen::Servo<double>& servo() { return servo_; }

 private:
  canopen::ServoConfig filled(canopen::ServoConfig config) {
    config.recorder = memory_;
    config.node.device_name = "smaservo";
    config.node.hardware_version = "simulated";
    config.node.software_version = "test";
    config.node.bit_rates = 0x1FFU & ~(1U << 5U);
    return config;
  }
  void answer_requests() {
    using enum canopen::Request;
    const canopen::Request request = servo_.request();
    if (request == none) {
      return;
    }
    if (request == reset_node || request == reset_communication) {
      if (request == reset_node) {
        rig_.state = Device<double>::start();
      }
      servo_.start(image_, now_us_);
      return;
    }
    if (request == store_all || request == store_communication || request == store_lss) {
      image_.resize(canopen::Node::image_size);
      image_.resize(servo_.image(image_));
    }
    if (request == restore_all || request == restore_communication) {
      image_.clear();
    }
    servo_.finish(servo_.request_number(), true);
  }

  std::vector<float> memory_;
  OwnSettings<double> settings_;
  Staging<double> staging_{settings_};
  canopen::Servo<double> servo_;
  Rig rig_;
  std::vector<std::uint8_t> image_;
  std::uint64_t now_us_ = 1'000'000;
  std::uint32_t changes_ = 0;
};

}  // namespace smaservo::test
