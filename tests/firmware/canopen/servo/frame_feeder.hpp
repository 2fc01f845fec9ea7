#pragma once
// Bytes as a bus of arbitrary frames: for random tests and fuzz targets. A byte below 32 lets as
// many steps pass; any other begins a frame of the service.

#include "tests/firmware/canopen/node/service.hpp"
#include "tests/firmware/canopen/servo/ceilings_at.hpp"
#include "tests/firmware/canopen/servo/servo_rig.hpp"

namespace smaservo::canopen {

class FrameFeeder {
 public:
  /// The rig's ceilings are those of its settings.
  FrameFeeder(ServoRig& rig, Service service)
      : rig_(rig), service_(service), ceilings_(ceilings_at(rig.staging.active())) {}

  /// False: something was heated that must not be, a ceiling was raised, or the node hangs.
  bool feed(std::span<const std::uint8_t> bytes) {
    bytes_ = bytes;
    while (!bytes_.empty()) {
      const std::uint8_t first = next();
      if (first < 32) {
        for (int i = 0; i < first; ++i) {
          rig_.step();
          if (!is_safe()) {
            return false;
          }
        }
      } else {
        frame_of(first, service_ == Service::all ? static_cast<Service>(first % 4U) : service_);
        rig_.sent.clear();
        if (!is_safe()) {
          return false;
        }
      }
    }
    return true;
  }

  /// Whatever has been: a reset of the node brings it back.
  bool comes_back() {
    rig_.run(3);
    rig_.image.clear();
    rig_.sent.clear();
    rig_.nmt(129, 0);
    rig_.run(3);
    const std::uint8_t id = rig_.node_id();
    const bool boots = id == 1 && rig_.take(0x701).size() == 1;
    return boots && rig_.upload({0x1000, 0}).data == little(servo_device_type, 4) &&
           rig_.set({0x1017, 0}, 0, 2) == Abort::none;
  }

 private:
  std::uint8_t next() {
    if (bytes_.empty()) {
      return 0;
    }
    const std::uint8_t byte = bytes_.front();
    bytes_ = bytes_.subspan(1);
    return byte;
  }
  hal::CanFrame with_data(std::uint32_t id, std::uint8_t length) {
    hal::CanFrame f;
    f.id = id;
    f.length = length;
    for (std::uint8_t i = 0; i < length; ++i) {
      f.data[i] = next();
    }
    return f;
  }
  void frame_of(std::uint8_t first, Service service) {
    hal::CanFrame f;
    switch (service) {
      case Service::sdo:
      case Service::all:
        f = with_data(0x600U + rig_.node_id() % 128U, 8);
        break;
      case Service::pdo: {
        constexpr std::array<std::uint32_t, 8> ids{0x201, 0x301, 0x401, 0x501,
                                                   0x80,  0x181, 0x601, 0x000};
        const std::uint32_t id = ids[first % ids.size()];
        f = with_data(id, id == 0x601 ? 8 : static_cast<std::uint8_t>(next() % 9U));
        f.remote = id == 0x181;
        break;
      }
      case Service::lss:
        f = with_data(0x7E5, 8);
        break;
      case Service::nmt: {
        constexpr std::array<std::uint32_t, 4> ids{0x000, 0x701, 0x710, 0x080};
        f = with_data(ids[first % ids.size()], static_cast<std::uint8_t>(next() % 9U));
        break;
      }
    }
    rig_.servo.receive(f, rig_.now_us);
    hal::CanFrame out;
    for (int i = 0; rig_.servo.take(out); ++i) {
      hangs_ = hangs_ || 200 < i;
    }
  }
  /// Heat needs Operation enabled, or an option code that says so.
  bool is_safe() const {
    const auto& o = rig_.servo.objects();
    const DriveState state = rig_.servo.axis().state();
    const bool may = state == DriveState::enabled ||
                     (state == DriveState::quick_stop && o.quick_stop_option == option_hold) ||
                     (state == DriveState::reacting && o.fault_option == option_safe_state);
    const bool shown = (o.statusword & 0x6FU) == 0x27 || state != DriveState::enabled;
    return !hangs_ && shown && (may || !rig_.servo.command().arm) && current_is_asked_for() &&
           is_below_ceilings();
  }
  /// By the command of the same step.
  bool current_is_asked_for() const { return rig_.output.drive_current_A == 0 || rig_.command.arm; }
  bool is_below_ceilings() const {
    const Ceilings now = ceilings_at(rig_.staging.active());
    const Ceilings& c = ceilings_;
    return now.current_A <= c.current_A && now.power_W <= c.power_W &&
           now.temperature_K <= c.temperature_K && now.stress_Pa <= c.stress_Pa &&
           now.trip_current_A <= c.trip_current_A &&
           now.trip_temperature_K <= c.trip_temperature_K && now.trip_stress_Pa <= c.trip_stress_Pa;
  }

  ServoRig& rig_;
  Service service_;
  Ceilings ceilings_;
  std::span<const std::uint8_t> bytes_;
  bool hangs_ = false;
};

}  // namespace smaservo::canopen
