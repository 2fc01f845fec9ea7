// Runs the device on a board of one's own: a class with the five functions of the concept Board.

#include <cmath>
#include <fmt/format.h>

#include "firmware/cycle.hpp"
#include "firmware/device/device.hpp"
#include "firmware/text/device_names.hpp"
#include "firmware/text/settings_file.hpp"
using namespace smaservo;
using Model = Plant<ThreePhase<double>>;
namespace {
/// This board has a simulated wire under 0.68 N; yours waits for its timer and reads its
/// converters.
class OwnBoard {
 public:
  explicit OwnBoard(const Model::Params& wire) : wire_(wire) {}
  hal::ReadStatus read(hal::Frame& frame) {
    const double ohm = Model::resistance_ohm(wire_, state_, 298.15);
    const double A = time_ns_ < command_.valid_until_ns ? command_.current_A : 0;
    Model::advance(wire_, state_, {A * A * ohm, 150e6, 298.15}, 1e-3);
    time_ns_ += 1'000'000;
    frame = {time_ns_, ++sequence_, A, A * ohm, 0.68, 24, std::nan(""), std::nan(""), false, false};
    return time_ns_ < 600'000'000 ? hal::ReadStatus::frame : hal::ReadStatus::end;
  }
  void drive(const hal::DriveCommand& command) { command_ = command; }
  void safe_off() { command_ = {}; }
  void kick() {}  // yours triggers the circuit that cuts the heat when the program hangs
  std::int64_t now_ns() const { return time_ns_; }

 private:
  Model::Params wire_;
  Model::State state_ = Model::rest(wire_, {298.15, 150e6});
  hal::DriveCommand command_{};
  std::int64_t time_ns_ = 0;
  std::uint32_t sequence_ = 0;
};
static_assert(hal::Board<OwnBoard>);
}  // namespace

int main() {
  const Prepared<double> prepared =
      prepare(text::load_settings_file("host-sim/scenarios/devices/smartflex-76um.toml"));
  Device<double>::State device = Device<double>::start();
  OwnBoard board(prepared.observer.model);
  hal::Frame frame{};
  DeviceStep<double> now{};
  const auto step = [&](const Inputs<double>& in, const Command<double>& command) {
    return Device<double>::step(prepared, device, in, command, 1e-3);
  };
  fmt::print("time s  state     current A  strain %\n");
  for (int i = 1; board.read(frame) == hal::ReadStatus::frame; ++i) {
    const Command<double> hold{.fresh = true, .arm = true, .mode = Mode::strain, .setpoint = 0.02};
    run_cycle(board, frame, hal::ReadStatus::frame, Heard<double>{hold, {}}, 1'000'000, now, step);
    if (i % 50 == 0) {
      fmt::print("{:6.2f}  {:8}  {:9.3f}  {:8.2f}\n", i * 1e-3, text::state_name(now.output.state),
                 now.output.drive_current_A, 100 * now.output.estimate.strain);
    }
  }
  board.safe_off();
}
