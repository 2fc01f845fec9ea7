// can_servo PORT NODE [EDS]: a servo on the bus, its wire simulated, in the clock's time, until it
// is killed; a partner for clients. LSS finds it without a node-id where NODE is 255.

#include <chrono>
#include <cstdlib>
#include <exception>
#include <fmt/format.h>
#include <fstream>
#include <iterator>
#include <poll.h>

#include "hal/linux/open_can.hpp"
#include "tests/can/simulated_servo.hpp"

namespace smaservo {
namespace {

/// Time that a slow machine does not catch up is left out.
constexpr std::uint64_t most_behind_us = 100'000;

std::uint64_t clock_us() {
  return static_cast<std::uint64_t>(std::chrono::duration_cast<std::chrono::microseconds>(
                                        std::chrono::steady_clock::now().time_since_epoch())
                                        .count());
}

std::string text_of(const char* path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) throw std::runtime_error(fmt::format("{}: cannot be read", path));
  return {std::istreambuf_iterator<char>(in), {}};
}

void serve(LinuxCan& port, test::SimulatedServo& servo) {
  pollfd waiting{port.descriptor(), POLLIN, 0};
  std::uint64_t offset_us = clock_us() - servo.now_us();
  for (;;) {
    poll(&waiting, 1, 1);
    CanFrame frame;
    while (port.receive(frame)) {
      servo.receive(frame);
      while (servo.take(frame)) port.send(frame);
    }
    const std::uint64_t now_us = clock_us() - offset_us;
    if (now_us > servo.now_us() + most_behind_us) offset_us += now_us - servo.now_us();
    while (servo.now_us() + test::SimulatedServo::step_us <= clock_us() - offset_us) {
      servo.step();
      while (servo.take(frame)) port.send(frame);
    }
  }
}

int run(int argc, char** argv) {
  if (argc < 3) {
    fmt::print(stderr, "can_servo PORT NODE [EDS]\n");
    return 2;
  }
  LinuxCan port = open_can(argv[1]);
  const auto node = static_cast<std::uint32_t>(std::strtoul(argv[2], nullptr, 10));
  const std::string eds = argc > 3 ? text_of(argv[3]) : "";
  canopen::ServoConfig config;
  config.node.eds = eds;
  test::SimulatedServo servo(test::SimulatedServo::usual_settings(node), config);
  serve(port, servo);
  return 0;
}

}  // namespace
}  // namespace smaservo

int main(int argc, char** argv) {
  try {
    return smaservo::run(argc, argv);
  } catch (const std::exception& error) {
    fmt::print(stderr, "can_servo: {}\n", error.what());
    return 1;
  }
}
