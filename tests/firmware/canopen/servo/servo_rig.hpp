#pragma once
// A servo node on a bus that is a queue, before a device that obeys the rules of failsafe.hpp and
// whose wire follows its set-point at once; and a client that speaks SDO.

#include <deque>
#include <optional>
#include <vector>

#include "firmware/canopen/servo/servo.hpp"
#include "firmware/safety/failsafe.hpp"
#include "tests/firmware/parameters/random_settings.hpp"

namespace smaservo::canopen {

using Bytes = std::vector<std::uint8_t>;

inline hal::CanFrame frame(std::uint32_t id, const Bytes& data) {
  hal::CanFrame f;
  f.id = id;
  f.length = static_cast<std::uint8_t>(data.size());
  std::ranges::copy(data, f.data.begin());
  return f;
}

inline Bytes little(std::uint64_t value, std::size_t size) {
  Bytes bytes(size);
  put_number(bytes, value);
  return bytes;
}

inline std::uint16_t emergency_code(const hal::CanFrame& f) {
  return static_cast<std::uint16_t>(take_number(f.payload().first(2)));
}

/// State and heat of a device, without its physics.
class FakeDevice {
 public:
  Output<double> step(const Command<double>& command, FaultSet external) {
    FailsafeInput in{};
    const FaultSet active = faults | external;
    const bool clear = command.clear_faults && !cleared_;
    cleared_ = command.clear_faults;
    latched_ = latch(latched_, active, state_, clear);
    first_ = latched_.empty() ? Fault::none : first_ == Fault::none ? latched_.first() : first_;
    in.state = state_;
    in.active = active;
    in.latched = latched_;
    in.arm = command.arm;
    in.arm_edge = command.arm && !armed_;
    armed_ = command.arm;
    in.started = 100 < ++steps_;
    in.blocked = !(active & blocking_faults).empty();
    in.checked = 50 < in_state_;
    in.passed = arms;
    in.safe = safe;
    in.may_hold = true;
    in.safe_over = 100 < in_state_;
    const FailsafeOutput next = failsafe(in);
    in_state_ = next.state == state_ ? in_state_ + 1 : 0;
    state_ = next.state;
    Output<double> out{};
    out.state = state_;
    const bool runs = next.heat == Heat::run && command.mode != Mode::off;
    out.drive_current_A = next.heat == Heat::none ? 0 : runs ? 0.1 : 0.01;
    out.mode = runs ? command.mode : Mode::off;
    out.setpoint = command.setpoint;
    if (runs && command.mode == Mode::position && moves) {
      strain_ = zero_strain - command.setpoint / length_m;
    }
    out.estimate.strain = strain_;
    out.estimate.temperature_K = 300;
    out.measurement.stress_Pa = 100e6;
    out.cooling = 0.5;
    out.wire_stress_Pa = 300e6;
    out.at_stop = true;
    out.active = active;
    out.latched = latched_;
    out.first_cause = first_;
    out.blocks = is_heated(state_) ? FaultSet{} : (active & blocking_faults) | latched_;
    out.time_us = 1000 * steps_;
    return out;
  }

  FaultSet faults;
  SafeState safe = SafeState::off;
  bool arms = true;
  bool moves = true;
  double zero_strain = 0.04, length_m = 0.1;

 private:
  DeviceState state_ = DeviceState::starting;
  FaultSet latched_;
  Fault first_ = Fault::none;
  std::uint64_t steps_ = 0, in_state_ = 0;
  double strain_ = 0.04;
  bool armed_ = false, cleared_ = false;
};

/// What a transfer came to.
struct Answer {
  Bytes data;
  Abort abort = Abort::none;
  bool came = true;
};

class ServoRig {
 public:
  static constexpr std::uint8_t id = 1;
  static constexpr const char* eds = "[FileInfo]\nEDSVersion=4.0\n";

  explicit ServoRig(const ServoConfig& with = {},
                    const Settings<double>& set = reference_settings(),
                    SettingsOwner<double>* owner = nullptr)
      : own(set),
        staging(owner != nullptr ? *owner : own),
        memory(4096),
        servo(filled(with, memory), staging) {
    device.length_m = set.wire.geometry.length_m;
    device.zero_strain = set.axis.zero_strain;
    servo.start({}, now_us);
  }

  /// One step of the loop and of the bus.
  void step() {
    now_us += 1000;
    servo.advance(now_us);
    if (steps_device) {
      command = servo.command();
      output = device.step(command, servo.external());
      servo.publish(output, Inputs<double>{}, 1e-3);
    }
    answer_requests();
    collect();
  }
  void run(int ms) {
    for (int i = 0; i < ms; ++i) {
      step();
    }
  }
  void send(std::uint32_t to, const Bytes& data) {
    servo.receive(frame(to, data), now_us);
    collect();
  }
  void nmt(std::uint8_t what, std::uint8_t whom = id) { send(0, {what, whom}); }
  void sync() { send(0x80, {}); }

  /// All frames with this identifier that have been sent and not been taken.
  std::vector<hal::CanFrame> take(std::uint32_t of) {
    std::vector<hal::CanFrame> found;
    std::deque<hal::CanFrame> rest;
    for (const hal::CanFrame& f : sent) {
      f.id == of ? found.push_back(f) : rest.push_back(f);
    }
    sent = rest;
    return found;
  }

  /// One request, one answer.
  std::optional<Bytes> ask(Bytes request) {
    request.resize(8);
    take(0x580U + node_id());
    send(0x600U + node_id(), request);
    for (int i = 0; i < 20; ++i) {
      const auto frames = take(0x580U + node_id());
      if (!frames.empty()) {
        return Bytes(frames[0].data.begin(), frames[0].data.end());
      }
      step();
    }
    return {};
  }
  static Bytes named(std::uint8_t command, Key key) {
    return {command, static_cast<std::uint8_t>(key.index),
            static_cast<std::uint8_t>(key.index >> 8U), key.sub};
  }

  Answer upload(Key key) {
    const auto first = ask(named(0x40, key));
    if (!first) {
      return {{}, Abort::none, false};
    }
    const Bytes& a = *first;
    if (a[0] == 0x80) {
      return {{}, static_cast<Abort>(take_number(std::span(a).subspan(4)))};
    }
    if ((a[0] & 2U) != 0) {
      return {Bytes(a.begin() + 4, a.end() - (a[0] >> 2U & 3U))};
    }
    Answer answer;
    std::uint8_t toggle = 0;
    for (;;) {
      const auto segment = ask({static_cast<std::uint8_t>(0x60U | toggle)});
      if (!segment) {
        return {};
      }
      const Bytes& s = *segment;
      if (s[0] == 0x80) {
        return {{}, static_cast<Abort>(take_number(std::span(s).subspan(4)))};
      }
      answer.data.insert(answer.data.end(), s.begin() + 1, s.end() - (s[0] >> 1U & 7U));
      toggle ^= 0x10U;
      if ((s[0] & 1U) != 0) {
        return answer;
      }
    }
  }
  Abort download(Key key, const Bytes& data) {
    if (data.size() <= 4) {
      Bytes request = named(static_cast<std::uint8_t>(0x23U | (4U - data.size()) << 2U), key);
      request.insert(request.end(), data.begin(), data.end());
      return result(ask(request));
    }
    Bytes request = named(0x21, key);
    const Bytes size = little(data.size(), 4);
    request.insert(request.end(), size.begin(), size.end());
    Abort abort = result(ask(request));
    std::uint8_t toggle = 0;
    for (std::size_t at = 0; abort == Abort::none && at < data.size(); at += 7) {
      const std::size_t n = std::min<std::size_t>(7, data.size() - at);
      Bytes segment{
          static_cast<std::uint8_t>(toggle | (7U - n) << 1U | (at + n == data.size() ? 1U : 0U))};
      segment.insert(segment.end(), data.begin() + static_cast<std::ptrdiff_t>(at),
                     data.begin() + static_cast<std::ptrdiff_t>(at + n));
      abort = result(ask(segment));
      toggle ^= 0x10U;
    }
    return abort;
  }
  Abort set(Key key, std::uint64_t value, std::size_t size) {
    return download(key, little(value, size));
  }
  Abort set_real(Key key, float value) { return set(key, as_bits(value), 4); }
  std::uint64_t get(Key key) { return take_number(upload(key).data); }
  float get_real(Key key) { return as_real(static_cast<std::uint32_t>(get(key))); }

  std::uint16_t status() { return servo.objects().statusword; }
  DriveState state() { return servo.axis().state(); }
  Abort control(std::uint16_t word) { return set({0x6040, 0}, word, 2); }
  /// From Switch on disabled to Operation enabled in this mode, by SDO.
  void enable(std::int8_t mode = 1) {
    run(150);
    set({0x6060, 0}, static_cast<std::uint8_t>(mode), 1);
    for (const std::uint16_t word : std::array<std::uint16_t, 3>{0x06, 0x07, 0x0F}) {
      control(word);
      run(3);
    }
    run(100);
  }
  std::uint8_t node_id() const { return servo.node().node_id(); }
  /// As the main answers a reset.
  void restart() { servo.start(image, now_us); }

  OwnSettings<double> own;  ///< unless the test has another owner
  Staging<double> staging;
  std::vector<float> memory;
  Servo<double> servo;
  FakeDevice device;
  std::uint64_t now_us = 1'000'000;
  Command<double> command;
  Output<double> output{};
  std::deque<hal::CanFrame> sent;
  Bytes image;                               ///< that is stored
  std::optional<Settings<double>> settings;  ///< likewise
  std::vector<Request> requests;
  bool answers = true;
  bool storage_works = true;
  bool steps_device = true;

 private:
  static ServoConfig filled(ServoConfig config, std::span<float> recorder) {
    config.recorder = recorder;
    config.node.device_name = "smaservo";
    config.node.hardware_version = "none";
    config.node.software_version = "0.1.0";
    config.node.eds = eds;
    config.node.bit_rates = 0x1FF & ~(1U << 5U);
    return config;
  }
  static Abort result(const std::optional<Bytes>& answer) {
    return !answer                 ? Abort::pending
           : answer->at(0) == 0x80 ? static_cast<Abort>(take_number(std::span(*answer).subspan(4)))
                                   : Abort::none;
  }
  void collect() {
    hal::CanFrame f;
    for (int i = 0; i < 1000 && servo.take(f); ++i) {
      sent.push_back(f);
    }
  }
  void answer_requests() {
    const Request request = servo.request();
    if (request == Request::none || !answers) {
      return;
    }
    requests.push_back(request);
    using enum Request;
    if (request == reset_node || request == reset_communication) {
      restart();
      return;
    }
    const bool communication =
        request == store_all || request == store_communication || request == store_lss;
    if (storage_works && communication) {
      image.resize(Node::image_size);
      image.resize(servo.image(image));
    }
    if (storage_works && (request == store_all || request == store_application)) {
      settings = staging.configured();
    }
    if (storage_works && (request == restore_all || request == restore_communication)) {
      image.clear();
    }
    servo.finish(servo.request_number(), storage_works);
  }
};

}  // namespace smaservo::canopen
