#include "hal/sim/front_end.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace smaservo::hal {
namespace {

Quantiser grid(double full_scale, int bits) {
  const double per_step = std::ldexp(1.0, bits - 1) / full_scale;
  return {1 / per_step, per_step, full_scale};
}

constexpr std::array readings{&Frame::current_A, &Frame::voltage_V, &Frame::load_N,
                              &Frame::supply_V,  &Frame::ambient_K, &Frame::driver_K};

/// The result is never a negative zero, which a trace would not preserve.
double quantised(double value, const Quantiser& grid) {
  if (std::isnan(value)) {
    return value;
  }
  const auto steps = static_cast<double>(std::lrint(value * grid.per_step));
  return std::clamp(steps * grid.step, -grid.full_scale, grid.full_scale);
}

}  // namespace

/// splitmix64: Steele, Lea and Flood (2014), 'Fast splittable pseudorandom number generators'.
std::uint64_t SensorNoise::bits() {
  state_ += 0x9E3779B97F4A7C15U;
  std::uint64_t z = state_;
  z = (z ^ z >> 30U) * 0xBF58476D1CE4E5B9U;
  z = (z ^ z >> 27U) * 0x94D049BB133111EBU;
  return z ^ z >> 31U;
}

double SensorNoise::operator()() {
  const std::uint64_t x = bits();
  const auto sum = (x & 0xFFFFU) + (x >> 16U & 0xFFFFU) + (x >> 32U & 0xFFFFU) + (x >> 48U);
  // Sum of four uniform numbers of 0..65535: mean 131070, variance 4 (65536² - 1)/12.
  constexpr double per_sd = 1 / 37837.22700343;
  return (static_cast<double>(sum) - 131070) * per_sd;
}

double SensorNoise::uniform() {
  return static_cast<double>(bits() >> 11U) * 0x1p-53;
}

FrontEnd::FrontEnd(const Converter& converter, const Sensors& sensors, std::uint64_t seed)
    : converter_(converter),
      sensors_(sensors),
      current_(grid(sensors.current_full_scale_A, sensors.bits)),
      voltage_(grid(sensors.voltage_full_scale_V, sensors.bits)),
      load_(grid(sensors.load_full_scale_N, sensors.bits)),
      noise_(seed),
      fault_noise_(~seed) {}

double FrontEnd::advance(const DriveCommand* command, double supply_V, double wire_ohm,
                         double dt_s) {
  const double path_ohm =
      (faults.circuit == Circuit::shorted ? 1 - faults.bridged_share : 1) * wire_ohm +
      converter_.lead_ohm;
  const double max_V = std::max(supply_V, 0.0);
  double wanted_A = 0;
  driven_V_ = 0;
  if (command != nullptr && converter_.voltage_drive) {
    driven_V_ = std::clamp(command->voltage_V, 0.0, max_V);
    wanted_A = driven_V_ / path_ohm;
  } else if (command != nullptr) {
    // A current source raises its voltage up to the supply's, also into an open circuit.
    wanted_A = std::min(std::max(command->current_A, 0.0), max_V / path_ohm);
    driven_V_ = wanted_A > 0 ? max_V : 0;
  }
  if (faults.circuit == Circuit::broken || faults.circuit == Circuit::open) {
    return current_A_ = 0;
  }
  wanted_A = std::min(wanted_A, converter_.max_A);
  // Switching off is not limited by the slew rate.
  const double step_A = converter_.slew_A_s * dt_s;
  current_A_ = wanted_A > 0 ? std::clamp(wanted_A, current_A_ - step_A, current_A_ + step_A) : 0;
  return current_A_;
}

double FrontEnd::between_sense_leads_V(double wire_ohm) const {
  switch (faults.circuit) {
    case Circuit::broken:
      return driven_V_;
    case Circuit::open:
      return 0;
    case Circuit::shorted:
      return current_A_ * wire_ohm * (1 - faults.bridged_share);
    case Circuit::closed:
      break;
  }
  return current_A_ * wire_ohm;
}

void FrontEnd::spoil(Frame& frame) {
  for (std::size_t i = 0; i < reading_count; ++i) {
    const SpoiltSensor& sensor = faults.sensors[i];
    double& value = frame.*readings[i];
    switch (sensor.fault) {
      case SensorFault::none:
        break;
      case SensorFault::missing:
        value = std::numeric_limits<double>::quiet_NaN();
        break;
      case SensorFault::stuck:
        value = last_.*readings[i];
        break;
      case SensorFault::offset:
        value += sensor.amount;
        break;
      case SensorFault::noise:
        value += sensor.amount * fault_noise_();
        break;
      case SensorFault::value:
        value = sensor.amount;
        break;
      case SensorFault::gain:
        value *= sensor.amount;
        break;
    }
  }
}

bool FrontEnd::read(const Truth& truth, Frame& frame) {
  const double load_N = faults.circuit == Circuit::broken ? 0 : truth.load_N;
  const double wire_V = between_sense_leads_V(truth.wire_ohm) * sensors_.resistance_gain;
  // The sensors' noise is also drawn when a fault makes it unnecessary, so that a fault changes
  // nothing else; each in its own statement, so that the order does not depend on the compiler.
  const double current_noise_A = sensors_.current_noise_A * noise_();
  const double voltage_noise_V = sensors_.voltage_noise_V * noise_();
  const double load_noise_N = sensors_.load_noise_N * noise_();
  if (faults.lost_share > 0 && fault_noise_.uniform() < faults.lost_share) {
    return false;
  }
  frame.current_A = current_A_ + current_noise_A;
  frame.voltage_V = wire_V + voltage_noise_V;
  frame.load_N = load_N * sensors_.load_gain + load_noise_N;
  frame.supply_V = truth.supply_V;
  frame.ambient_K = truth.ambient_K;
  frame.driver_K = truth.driver_K;
  frame.emergency_stop = faults.emergency_stop;
  frame.driver_fault = faults.driver_fault;
  if (faults.spoils()) {
    spoil(frame);
  }
  frame.current_A = quantised(frame.current_A, current_);
  frame.voltage_V = quantised(frame.voltage_V, voltage_);
  frame.load_N = quantised(frame.load_N, load_);
  last_ = frame;
  return true;
}

}  // namespace smaservo::hal
