// The device on a microcontroller without an operating system: a loop with the timer's period, a
// CANopen node, settings in two slots.

#include <optional>

#include "firmware/canopen/servo/servo.hpp"
#include "firmware/cycle.hpp"
#include "firmware/device/adopt.hpp"
#include "firmware/mcu/device.hpp"
#include "firmware/parameters/store/store.hpp"
#include "hal/cortex-m/board.hpp"
#include "hal/cortex-m/start_up.hpp"

namespace smaservo::mcu {
namespace {

/// All objects that live as long as the program. The class is instantiated statically, so the
/// linker counts its memory.
class Loop {
 public:
  Loop(const Settings<float>& settings, std::uint32_t period_us, FaultSet found)
      : board_(period_us),
        period_us_(period_us),
        settings_(settings),
        servo_({}, staging_),
        found_(found) {}

  bool is_open() const { return board_.is_open() && can_.is_open(); }

  void run() {
    board_.start();
    servo_.start({}, board_.now_us());
    hal::FrameOf<float> frame{};
    for (hal::ReadStatus status = board_.read(frame); status != hal::ReadStatus::end;
         status = board_.read(frame)) {
      communicate();
      step(frame, status);
    }
    board_.safe_off();
  }

 private:
  void communicate() {
    hal::CanFrame frame;
    while (can_.receive(frame)) {
      servo_.receive(frame, board_.now_us());
    }
    servo_.advance(board_.now_us());
    while (servo_.take(frame)) {
      can_.send(frame);
    }
    answer(servo_.request());
    if (adopted_ != settings_.changes()) {
      adopted_ = settings_.changes();
      adopt(prepared_, staging_.active(), device_);
    }
  }
  void answer(canopen::Request request) {
    using canopen::Request;
    switch (request) {
      case Request::none:
        break;
      case Request::reset_node:
      case Request::reset_communication:
        board_.safe_off();
        device_ = Device<float>::start();
        servo_.start({}, board_.now_us());
        break;
      case Request::store_application: {
        cortex_m::SlotFiles slots;
        const bool done = save_settings(slots, staging_.configured()).ok();
        found_ = done ? FaultSet{} : found_;
        servo_.finish(servo_.request_number(), done);
        break;
      }
      default:
        servo_.finish(servo_.request_number(),
                      false);  // this program does not store the communication's settings
    }
  }
  void step(const hal::FrameOf<float>& frame, hal::ReadStatus status) {
    const float dt_s = 1e-6F * static_cast<float>((board_.missed() + 1) * period_us_);
    const Heard<float> heard{servo_.command(), servo_.external() | found_, board_.missed() > 0};
    DeviceStep<float> now;
    run_cycle(board_, frame, status, heard, std::int64_t{period_us_} * 1000, now,
              [&](const Inputs<float>& in, const Command<float>& command) {
                return step_device(prepared_, device_, in, command, dt_s);
              });
    servo_.publish(now.output, now.inputs, dt_s);
  }

  cortex_m::PipeBoard board_;
  cortex_m::PipeCan can_;
  std::uint32_t period_us_;
  OwnSettings<float> settings_;
  Staging<float> staging_{settings_};
  canopen::Servo<float> servo_;
  Prepared<float> prepared_ = prepare(staging_.active());
  Device<float>::State device_ = Device<float>::start();
  FaultSet found_;             ///< faults found at the start; storing settings acknowledges them
  std::uint32_t adopted_ = 0;  ///< number of the settings in force
};

std::optional<Loop> loop;

}  // namespace
}  // namespace smaservo::mcu

void sys_tick_interrupt() {
  smaservo::cortex_m::ticks = smaservo::cortex_m::ticks + 1;
}

int application() {
  using namespace smaservo;
  cortex_m::SlotFiles slots;
  const Loaded<float> loaded = load_settings<float>(slots);
  if (loaded.reason == LoadReason::none) {
    semihosting::print("no settings in slot-0 and slot-1\n");
    return 2;
  }
  mcu::loop.emplace(loaded.settings,
                    static_cast<std::uint32_t>(loaded.settings.timing.period_s * 1e6F),
                    loaded.may_be_older ? FaultSet(Fault::store_outdated) : FaultSet{});
  if (!mcu::loop->is_open()) {
    semihosting::print("no pipes drive, readings, can-out, can-in\n");
    return 2;
  }
  mcu::loop->run();
  return 0;
}
