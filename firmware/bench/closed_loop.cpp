#include "firmware/bench/closed_loop.hpp"

#include <cmath>

namespace smaservo::bench {

ClosedLoop::ClosedLoop(const ClosedLoopScenario& scenario)
    : prepared_(prepare(scenario.settings)),
      period_ns_(scenario.board.period_ns),
      end_ns_(std::llround(scenario.duration_s * 1e9)),
      nominal_s_(scenario.settings.timing.period_s),
      first_(prepared_, scenario.plant, scenario.board),
      program_(scenario.program),
      events_(scenario.events, scenario.board.surroundings) {
  if (scenario.pair) {
    second_drives_ = scenario.pair->driven;
    second_ =
        std::make_unique<ControlledWire>(prepared_, scenario.pair->plant, scenario.pair->board);
    pair_.emplace(first_.board, scenario.board.geometry, second_->board,
                  scenario.pair->board.geometry);
    rest_strains_ = first_.board.truth().strain + second_->board.truth().strain;
  }
}

void ClosedLoop::ControlledWire::step(hal::ReadStatus status, const hal::Frame& frame,
                                      const Heard<double>& heard, double dt_s,
                                      std::int64_t period_ns, DeviceStep<double>& now) {
  run_cycle(board, frame, status, heard, period_ns, now,
            [&](const Inputs<double>& in, const Command<double>& command) {
              return Device<double>::step(prepared_, device, in, command, dt_s);
            });
}

/// The command for the second wire: it gets shorter by what the first one gets longer. Modes other
/// than strain have no opposite and switch it off.
Command<double> ClosedLoop::opposite(const Command<double>& command) const {
  Command<double> other = command;
  if (command.mode == Mode::strain) {
    other.setpoint = rest_strains_ - command.setpoint;
  } else {
    other.mode = Mode::off;
    other.arm = false;
  }
  return other;
}

bool ClosedLoop::step() {
  if (began_ && time_ns_ + period_ns_ >= end_ns_) {
    return false;
  }
  const double event_s = began_ ? static_cast<double>(time_ns_) * 1e-9 : 0;
  events_.apply(event_s, first_.board);
  if (events_.reboots()) {
    first_.device = Device<double>::start();
    first_.board.safe_off();
    if (second_) {
      second_->device = Device<double>::start();
      second_->board.safe_off();
    }
  }
  hal::Frame frame{};
  hal::Frame other_frame{};
  hal::ReadStatus status{};
  hal::ReadStatus other_status{};
  if (pair_) {
    const auto both = pair_->read(frame, other_frame);
    status = both[0];
    other_status = both[1];
  } else {
    status = first_.board.read(frame);
  }
  // dt_s is computed as a replay computes it from the times in the trace.
  const double dt_s = began_ ? static_cast<double>(frame.time_ns - time_ns_) * 1e-9 : nominal_s_;
  began_ = true;
  time_ns_ = frame.time_ns;
  cycle_.time_s = static_cast<double>(time_ns_) / 1e9;
  cycle_.truth = first_.board.truth();
  first_.step(status, frame, {program_.at(cycle_.time_s), {}, events_.late()}, dt_s, period_ns_,
              cycle_);
  if (second_ && second_drives_) {
    DeviceStep<double> unused{};
    second_->step(other_status, other_frame, {opposite(cycle_.command), {}}, dt_s, period_ns_,
                  unused);
  }
  return true;
}

std::optional<OtherWire> ClosedLoop::other() const {
  if (!second_) {
    return std::nullopt;
  }
  const hal::SimTruth truth = second_->board.truth();
  return OtherWire{truth.strain, truth.current_A, truth.hottest_K};
}

}  // namespace smaservo::bench
