#include "hal/sim/board.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "hal/sim/balance.hpp"

namespace smaservo::hal {
namespace {

constexpr std::int64_t longest_part_ns = 1'000'000;

}  // namespace

SimBoard::SimBoard(std::unique_ptr<SimulatedWire> wire, const SimSetup& setup)
    : surroundings(setup.surroundings),
      wire_(std::move(wire)),
      front_end_(setup.converter, setup.sensors, setup.seed),
      load_(setup.load),
      load_random_(setup.seed + 2),
      area_m2_(setup.geometry.area_m2()),
      reads_supply_(setup.reads_supply),
      reads_ambient_(setup.reads_ambient),
      reads_driver_(setup.reads_driver),
      period_ns_(setup.period_ns),
      parts_(static_cast<int>((setup.period_ns + longest_part_ns - 1) / longest_part_ns)),
      part_s_(static_cast<double>(setup.period_ns) * 1e-9 / parts_),
      stress_Pa_(load_.stress_Pa()) {
  wire_->rest(surroundings.ambient_K, stress_Pa_);
  look();
}

void SimBoard::look() {
  strain_ = wire_->strain();
  ohm_ = wire_->resistance_ohm();
}

void SimBoard::begin_part() {
  const auto now_ns = time_ns_ + static_cast<std::int64_t>(part_began_s_ * 1e9);
  const bool leased = now_ns < command_.valid_until_ns;
  front_end_.advance(leased ? &command_ : nullptr, surroundings.supply_V, ohm_, part_s_);
}

double SimBoard::strain_after(double stress_Pa) const {
  return wire_->strain_after(front_end_.current_A(), around(stress_Pa), part_s_) +
         surroundings.slip;
}

void SimBoard::finish_part(double stress_Pa) {
  stress_Pa_ = stress_Pa;
  wire_->advance(front_end_.current_A(), around(stress_Pa), part_s_);
  look();
  part_began_s_ += part_s_;
}

ReadStatus SimBoard::sample(Frame& frame) {
  time_ns_ += started_ ? period_ns_ : 0;
  part_began_s_ = 0;
  started_ = true;
  constexpr double none = std::numeric_limits<double>::quiet_NaN();
  const double driver_K = surroundings.ambient_K + surroundings.driver_above_K;
  frame.time_ns = time_ns_;
  frame.sequence = sequence_++;
  const bool came = front_end_.read({.wire_ohm = ohm_,
                                     .load_N = stress_Pa_ * area_m2_,
                                     .supply_V = reads_supply_ ? surroundings.supply_V : none,
                                     .ambient_K = reads_ambient_ ? surroundings.ambient_K : none,
                                     .driver_K = reads_driver_ ? driver_K : none},
                                    frame);
  return came ? ReadStatus::frame : ReadStatus::nothing;
}

ReadStatus SimBoard::read(Frame& frame) {
  for (int i = 0; i < parts(); ++i) {
    begin_part();
    const double time_s = static_cast<double>(time_ns_) * 1e-9 + part_began_s_;
    load_.advance(time_s, part_s_, strain_ + surroundings.slip, load_random_);
    const bool carries = front_end_.faults.circuit != Circuit::broken;
    finish_part(carries ? pull_Pa(load_.stress_Pa() + surroundings.added_stress_Pa) : 0);
  }
  return sample(frame);
}

/// The stress of the load, or the greater one at which the wire is not shorter than its stop
/// allows.
double SimBoard::pull_Pa(double load_Pa) const {
  const auto excess = [&](double stress_Pa) {
    return strain_after(stress_Pa) - surroundings.stop_strain;
  };
  if (!(surroundings.stop_strain > 0) || excess(load_Pa) >= 0) {
    return load_Pa;
  }
  return balance(std::max(stress_Pa_, load_Pa), load_Pa, 1e6, 1e-9, excess);
}

SimTruth SimBoard::truth() const {
  return {strain_ + surroundings.slip, wire_->hottest_K(), front_end_.current_A(), stress_Pa_};
}

}  // namespace smaservo::hal
