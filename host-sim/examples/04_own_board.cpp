// Runs the device on a board of one's own: a class with the five functions of the concept Board.

#include <cmath>
#include <cstdio>
#include <smaservo/firmware/cycle.hpp>
#include <smaservo/firmware/device/servo.hpp>
#include <smaservo/firmware/text/device_names.hpp>
#include <smaservo/firmware/text/settings_file.hpp>
#include <smaservo/model/wire/wire_plant.hpp>

using namespace smaservo;
namespace {
/// This board has a simulated wire under 0.68 N; yours waits for its timer and reads its
/// converters.
class OwnBoard {
 public:
  explicit OwnBoard(const Wire<double>& wire) : wire_(wire, 0.68) {}
  hal::ReadStatus read(hal::Frame& frame) {
    const double A = time_ns_ < command_.valid_until_ns ? command_.current_A : 0;
    const double V = A * wire_.output().resistance_ohm;
    wire_.update({.current_A = A, .load_N = 0.68}, 1e-3);
    time_ns_ += 1'000'000;
    frame = {time_ns_, ++sequence_, A, V, 0.68, 24, std::nan(""), std::nan(""), false, false};
    return time_ns_ < 600'000'000 ? hal::ReadStatus::frame : hal::ReadStatus::end;
  }
  void drive(const hal::DriveCommand& command) { command_ = command; }
  void safe_off() { command_ = {}; }
  void kick() {}  // yours triggers the circuit that cuts the heat when the program hangs
  std::int64_t now_ns() const { return time_ns_; }

 private:
  WirePlant<double> wire_;
  hal::DriveCommand command_{};
  std::int64_t time_ns_ = 0;
  std::uint32_t sequence_ = 0;
};
static_assert(hal::Board<OwnBoard>);
}  // namespace

int main() {
  Servo servo{text::load_settings_file("host-sim/scenarios/devices/smartflex-76um.toml")};
  OwnBoard board(servo.settings().wire);
  hal::Frame frame{};
  DeviceStep<double> now{};
  const auto step = [&](const auto& in, const auto& command) {
    return servo.step(in, command, 1e-3);
  };
  std::puts("time s  state     current A  strain %");
  for (int i = 1; board.read(frame) == hal::ReadStatus::frame; ++i) {
    const Command<double> hold{.fresh = true, .arm = true, .mode = Mode::strain, .setpoint = 0.02};
    run_cycle(board, frame, hal::ReadStatus::frame, Heard<double>{hold, {}}, 1'000'000, now, step);
    if (i % 50 == 0) {
      std::printf("%6.2f  %-8s  %9.3f  %8.2f\n", i * 1e-3,
                  std::string(text::state_name(now.output.state)).c_str(),
                  now.output.drive_current_A, 100 * now.output.estimate.strain);
    }
  }
  board.safe_off();
}
