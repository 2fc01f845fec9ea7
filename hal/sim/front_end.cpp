#include "hal/sim/front_end.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace smaservo {
namespace {

double converter_step(double full_scale, int bits) {
  return full_scale / std::ldexp(1.0, bits - 1);
}

/// Never a negative zero: it would not survive a trace.
double quantised(double value, double step, double full_scale) {
  return std::clamp(std::round(value / step) * step, -full_scale, full_scale) + 0.0;
}

}  // namespace

double SensorNoise::operator()() {
  const std::uint64_t bits = random_();
  const auto sum =
      (bits & 0xFFFFU) + (bits >> 16U & 0xFFFFU) + (bits >> 32U & 0xFFFFU) + (bits >> 48U);
  // Four uniform numbers of 0..65535: mean 131070, variance 4 (65536² - 1)/12.
  constexpr double per_sd = 1 / 37837.22700343;
  return (static_cast<double>(sum) - 131070) * per_sd;
}

double SensorNoise::uniform() {
  return static_cast<double>(random_() >> 11U) * 0x1p-53;
}

FrontEnd::FrontEnd(const Converter& converter, const Sensors& sensors, std::uint64_t seed)
    : converter_(converter),
      sensors_(sensors),
      current_step_A_(converter_step(sensors.current_full_scale_A, sensors.bits)),
      voltage_step_V_(converter_step(sensors.voltage_full_scale_V, sensors.bits)),
      load_step_N_(converter_step(sensors.load_full_scale_N, sensors.bits)),
      noise_(seed),
      fault_noise_(seed + 1) {}

double FrontEnd::advance(const DriveCommand* command, double supply_V, double wire_ohm,
                         double dt_s) {
  const double path_ohm =
      (faults.circuit == Circuit::shorted ? 1 - faults.bridged_share : 1) * wire_ohm +
      converter_.lead_ohm;
  const double most_V = std::max(supply_V, 0.0);
  double wanted_A = 0;
  driven_V_ = 0;
  if (command != nullptr && converter_.voltage_drive) {
    driven_V_ = std::clamp(command->voltage_V, 0.0, most_V);
    wanted_A = driven_V_ / path_ohm;
  } else if (command != nullptr) {
    // A current source drives what it finds against its supply, an open end too.
    wanted_A = std::min(std::max(command->current_A, 0.0), most_V / path_ohm);
    driven_V_ = wanted_A > 0 ? most_V : 0;
  }
  if (faults.circuit == Circuit::broken || faults.circuit == Circuit::open) {
    return current_A_ = 0;
  }
  wanted_A = std::min(wanted_A, converter_.greatest_A);
  // To switch off takes no slew.
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

double FrontEnd::reading(Reading which, double value, double step, double full_scale) {
  const auto i = static_cast<std::size_t>(which);
  const SpoiltSensor& sensor = faults.sensors[i];
  switch (sensor.fault) {
    case SensorFault::none:
      return last_good_[i] = quantised(value, step, full_scale);
    case SensorFault::missing:
      return std::numeric_limits<double>::quiet_NaN();
    case SensorFault::stuck:
      return last_good_[i];
    case SensorFault::offset:
      return quantised(value + sensor.amount, step, full_scale);
    case SensorFault::noise:
      return quantised(value + sensor.amount * fault_noise_(), step, full_scale);
    case SensorFault::value:
      break;
  }
  return quantised(sensor.amount, step, full_scale);
}

bool FrontEnd::read(const Truth& truth, Frame& frame) {
  const double load_N = faults.circuit == Circuit::broken ? 0 : truth.load_N;
  const double wire_V = between_sense_leads_V(truth.wire_ohm) * sensors_.resistance_gain;
  // The sensors' noise is drawn whatever is wrong, one statement each: a fault changes nothing
  // else, and the order does not depend on the compiler.
  const double current_noise_A = sensors_.current_noise_A * noise_();
  const double voltage_noise_V = sensors_.voltage_noise_V * noise_();
  const double load_noise_N = sensors_.load_noise_N * noise_();
  if (faults.lost_share > 0 && fault_noise_.uniform() < faults.lost_share) {
    return false;
  }
  constexpr double finest = 1e-3;  // V and K
  constexpr double no_end = std::numeric_limits<double>::infinity();
  frame.current_A = reading(Reading::current, current_A_ + current_noise_A, current_step_A_,
                            sensors_.current_full_scale_A);
  frame.voltage_V = reading(Reading::voltage, wire_V + voltage_noise_V, voltage_step_V_,
                            sensors_.voltage_full_scale_V);
  frame.load_N = reading(Reading::load, load_N * sensors_.load_gain + load_noise_N, load_step_N_,
                         sensors_.load_full_scale_N);
  frame.supply_V = reading(Reading::supply, truth.supply_V, finest, no_end);
  frame.ambient_K = reading(Reading::ambient, truth.ambient_K, finest, no_end);
  frame.driver_K = reading(Reading::driver, truth.driver_K, finest, no_end);
  frame.emergency_stop = faults.emergency_stop;
  frame.driver_fault = faults.driver_fault;
  return true;
}

}  // namespace smaservo
