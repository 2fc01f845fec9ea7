#pragma once
// A board of parts that a test holds in its hands.

#include <string>
#include <vector>

#include "hal/linux/board.hpp"
#include "hal/linux/system/clock.hpp"

namespace smaservo::test {

struct Hands {
  bool comes = true, takes = true, stop = false, fault = false, enabled = false, line_dead = false;
  int kicks = 0;
  double current_A = 0;
  std::vector<std::string> order;
};
class HandDigitizer : public hal::Digitizer {
 public:
  explicit HandDigitizer(Hands& hands) : hands_(hands) {}
  bool read(hal::RawFrame& raw) override {
    raw = {.time_ns = hal::monotonic_ns(), .sequence = frames_++, .codes = {1000, 2000, 3000}};
    return hands_.comes;
  }

 private:
  Hands& hands_;
  std::uint32_t frames_ = 0;
};
class HandDrive : public hal::OutputStage {
 public:
  explicit HandDrive(Hands& hands) : hands_(hands) {}
  bool put(const hal::DriveCommand& command) override {
    hands_.order.emplace_back("put");
    hands_.current_A = hands_.takes ? command.current_A : hands_.current_A;
    return hands_.takes;
  }
  bool off() override { return put({}); }
  hal::OffAction off_action() override { return {-1, 0, nullptr, 0}; }

 private:
  Hands& hands_;
};
class HandLines : public hal::Lines {
 public:
  explicit HandLines(Hands& hands) : hands_(hands) {}
  bool emergency_stop() override { return hands_.stop; }
  bool driver_fault() override { return hands_.fault; }
  bool enable(bool on) override {
    hands_.order.emplace_back(on ? "on" : "off");
    hands_.enabled = hands_.line_dead ? hands_.enabled : on;
    return !hands_.line_dead;
  }
  bool kick() override {
    ++hands_.kicks;
    return true;
  }
  std::vector<hal::OffAction> off_actions() override { return {}; }

 private:
  Hands& hands_;
};

inline hal::LinuxBoardParts parts(Hands& hands) {
  hal::LinuxBoardParts all;
  all.digitizer = std::make_unique<HandDigitizer>(hands);
  all.drive = std::make_unique<HandDrive>(hands);
  all.lines = std::make_unique<HandLines>(hands);
  all.slow =
      std::make_unique<hal::SlowSensors>(hal::LinuxRoots{}, std::array<hal::SlowSensor, 3>{});
  all.calibration = {{0, 1e-4, 0}, {1, 1e-3, 500}, true, {2, 0.01, 3000}};
  return all;
}

}  // namespace smaservo::test
