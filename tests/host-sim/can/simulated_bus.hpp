#pragma once
// A bus in virtual time with one servo on it.

#include <deque>

#include "host-sim/can/bus/bus.hpp"
#include "tests/can/simulated_servo.hpp"

namespace smaservo::test {

class SimulatedBus final : public can::Bus {
 public:
  static constexpr unsigned node = 5;

  SimulatedBus() : servo_(SimulatedServo::usual_settings(node), {}) {}

  void send(const hal::CanFrame& frame) override {
    servo_.receive(frame);
    collect();
  }
  bool receive(hal::CanFrame& frame, std::int64_t until_us) override {
    while (frames_.empty() && now_us() < until_us) {
      servo_.step();
      collect();
    }
    if (frames_.empty()) {
      return false;
    }
    frame = frames_.front();
    frames_.pop_front();
    return true;
  }
  std::int64_t now_us() const override { return static_cast<std::int64_t>(servo_.now_us()); }
  std::string name() const override { return "sim"; }

  SimulatedServo& servo() { return servo_; }
  /// The i-th answer to SDO from now on is lost.
  void lose_answer(int i) { to_lose_ = i; }

 private:
  void collect() {
    hal::CanFrame frame;
    while (servo_.take(frame)) {
      const bool answer = frame.id == 0x580 + node && to_lose_ > 0;
      to_lose_ -= answer ? 1 : 0;
      const bool lost = answer && to_lose_ == 0;
      if (!lost) {
        frames_.push_back(frame);
      }
    }
  }

  SimulatedServo servo_;
  std::deque<hal::CanFrame> frames_;
  int to_lose_ = 0;
};

}  // namespace smaservo::test
