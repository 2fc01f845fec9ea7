// The device on a microcontroller, without an operating system.

#include "firmware/board_io.hpp"
#include "firmware/device.hpp"
#include "firmware/store.hpp"
#include "hal/cortex-m/board.hpp"
#include "hal/cortex-m/start_up.hpp"

namespace smaservo {
namespace {

constexpr std::uint32_t clock_Hz = 25'000'000;

/// Heat ends with the loop, but not with one lost turn of it.
constexpr std::int64_t leased_periods = 3;

Prepared<float> prepared;
Device<float>::State device;

bool prepare_from_store() {
  cortex_m::SlotFiles slots;
  const Loaded<float> loaded = load_settings<float>(slots);
  prepared = prepare(loaded.settings);
  return loaded.reason != LoadReason::none;
}

/// Holds one strain. A user's commands come by CAN.
Command<float> command() {
  return {.fresh = true, .arm = true, .mode = Mode::strain, .setpoint = 0.02F};
}

void run(cortex_m::PipeBoard& board, std::int64_t period_ns) {
  device = Device<float>::start();
  board.start();
  Frame frame{};
  for (ReadStatus status = board.read(frame); status != ReadStatus::end;
       status = board.read(frame)) {
    Inputs<float> in = inputs_of<float>(frame, status);
    in.deadline_missed = board.missed() > 0;
    const float dt_s = static_cast<float>(board.missed() + 1) * prepared.settings.timing.period_s;
    const Output<float> out = Device<float>::step(prepared, device, in, command(), dt_s);
    board.drive(drive_of(out, board.now_ns(), leased_periods * period_ns));
    board.kick();
  }
  board.safe_off();
}

}  // namespace
}  // namespace smaservo

void sys_tick_interrupt() { smaservo::cortex_m::ticks = smaservo::cortex_m::ticks + 1; }

int application() {
  using namespace smaservo;
  if (!prepare_from_store()) {
    semihosting::print("no settings in slot-0 and slot-1\n");
    return 2;
  }
  const auto period_us = static_cast<std::uint32_t>(prepared.settings.timing.period_s * 1e6F);
  static cortex_m::PipeBoard board(clock_Hz, period_us);
  if (!board.is_open()) {
    semihosting::print("no pipes drive and readings\n");
    return 2;
  }
  run(board, std::int64_t{period_us} * 1000);
  return 0;
}
