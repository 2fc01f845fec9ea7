#include "firmware/daemon/boards/simulation.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>

#include "model/files/error.hpp"

namespace smaservo::daemon {

Simulation::Simulation(const bench::ClosedLoopScenario& scenario)
    : board_(bench::make_plant(scenario.plant), scenario.board),
      program_(scenario.program),
      events_(scenario.events, scenario.board.surroundings),
      has_program_(!scenario.program.empty()),
      period_ns_(scenario.board.period_ns),
      end_ns_(scenario.duration_s > 0 ? std::llround(scenario.duration_s * 1e9)
                                      : std::numeric_limits<std::int64_t>::max()) {
  if (scenario.pair || std::ranges::any_of(scenario.events, &bench::SimEvent::reboots)) {
    throw files::ConfigError(
        fmt::format("{}: has a pair of wires or a restart of the device, which only host-sim "
                    "simulate can run",
                    scenario.name));
  }
}

hal::ReadStatus Simulation::read(hal::Frame& frame) {
  if (began_ && board_.now_ns() + period_ns_ >= end_ns_) {
    return hal::ReadStatus::end;
  }
  events_.apply(began_ ? static_cast<double>(board_.now_ns()) * 1e-9 : 0, board_);
  began_ = true;
  return board_.read(frame);
}

Heard<double> Simulation::listen(double time_s) {
  return {has_program_ ? program_.at(time_s) : Command<double>{.fresh = true}, {}, events_.late()};
}

Demonstration::Demonstration(const Settings<double>& settings) {
  const double cold = settings.wire.nominal_stroke;
  const double max = std::min(cold, settings.limits.max_strain);
  long_ = std::max(0.75 * max, settings.limits.min_strain);
  short_ = std::max(0.35 * max, settings.limits.min_strain);
}

Heard<double> Demonstration::listen(double time_s) {
  constexpr double rest_s = 0.5;
  constexpr double half_s = 2;
  const bool armed = time_s >= rest_s;
  const bool up = std::fmod(time_s, 2 * half_s) < half_s;
  return {{.fresh = true,
           .arm = armed,
           .mode = armed ? Mode::strain : Mode::off,
           .setpoint = up ? short_ : long_},
          {}};
}

}  // namespace smaservo::daemon
