#pragma once
// Steps of a device as a file that a microcontroller reads: its settings as a stored image, then
// for each step what goes in and what came out of it on a PC. Numbers are little-endian.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>

#include "firmware/device/device.hpp"
#include "firmware/parameters/store/store.hpp"

namespace smaservo::mcu {

/// How far each number of the outputs goes in a file; never 0.
using Ranges = std::array<float, 11>;

struct StepFileHeader {
  static constexpr std::uint32_t own_magic = 0x50455453;  // "STEP"
  std::uint32_t magic, image_bytes, steps;
  Ranges ranges;
};

enum StepFlag : std::uint32_t {
  fresh_sample = 1U << 0U,
  emergency_stop = 1U << 1U,
  driver_fault = 1U << 2U,
  deadline_missed = 1U << 3U,
  fresh_command = 1U << 4U,
  arm = 1U << 5U,
  clear_faults = 1U << 6U,
  restart = 1U << 7U,  ///< the device is switched on before this step
};

struct StepInputs {
  float dt_s;
  float current_A, voltage_V, load_N, supply_V, ambient_K, driver_K;
  float setpoint, proportional, integral, derivative;
  std::uint32_t sequence, flags, mode;
  std::uint32_t external_low, external_high;
};

struct StepOutputs {
  float current_A, voltage_V, reference, power_W;
  float resistance_ohm, strain, strain_sd, temperature_K, martensite, ambient_K, hot_spot_K;
  std::uint32_t state, mode, limit_reasons;
  std::uint32_t latched_low, latched_high;
};

/// The same by their kind: numbers, and what is equal or not.
struct StepNumbers {
  static constexpr std::size_t strain = 5;
  Ranges number;
  std::array<std::uint32_t, 5> words;
};
static_assert(sizeof(StepNumbers) == sizeof(StepOutputs));

/// Of each file so many are counted in integers, which takes long.
inline constexpr std::uint32_t steps_in_integers = 3000;

struct StepRecord {
  StepInputs inputs;
  StepOutputs outputs;
};
static_assert(sizeof(StepRecord) == 128 && std::is_trivially_copyable_v<StepRecord>);

constexpr std::uint32_t low(std::uint64_t bits) {
  return static_cast<std::uint32_t>(bits);
}
constexpr std::uint32_t high(std::uint64_t bits) {
  return static_cast<std::uint32_t>(bits >> 32U);
}

template <class S>
StepInputs pack(const Inputs<S>& in, const Command<S>& command, S dt_s, bool starts) {
  const auto f = [](S x) { return static_cast<float>(x); };
  const auto flag = [](bool on, StepFlag bit) { return on ? bit : std::uint32_t{0}; };
  const std::uint32_t flags =
      flag(in.fresh, fresh_sample) | flag(in.emergency_stop, emergency_stop) |
      flag(in.driver_fault, driver_fault) | flag(in.deadline_missed, deadline_missed) |
      flag(command.fresh, fresh_command) | flag(command.arm, arm) |
      flag(command.clear_faults, clear_faults) | flag(starts, restart);
  return {f(dt_s),
          f(in.sample.current_A),
          f(in.sample.voltage_V),
          f(in.sample.load_N),
          f(in.supply_V),
          f(in.ambient_K),
          f(in.driver_K),
          f(command.setpoint),
          f(command.scale.proportional),
          f(command.scale.integral),
          f(command.scale.derivative),
          in.sequence,
          flags,
          static_cast<std::uint32_t>(command.mode),
          low(in.external.bits()),
          high(in.external.bits())};
}

template <class S>
Inputs<S> inputs_of(const StepInputs& r) {
  Inputs<S> in{};
  in.fresh = (r.flags & fresh_sample) != 0;
  in.sequence = r.sequence;
  in.sample = {S(r.current_A), S(r.voltage_V), S(r.load_N)};
  in.supply_V = S(r.supply_V);
  in.ambient_K = S(r.ambient_K);
  in.driver_K = S(r.driver_K);
  in.emergency_stop = (r.flags & emergency_stop) != 0;
  in.driver_fault = (r.flags & driver_fault) != 0;
  in.deadline_missed = (r.flags & deadline_missed) != 0;
  in.external = FaultSet::from_bits(r.external_low | std::uint64_t{r.external_high} << 32U);
  return in;
}

template <class S>
Command<S> command_of(const StepInputs& r) {
  return {(r.flags & fresh_command) != 0,
          (r.flags & arm) != 0,
          (r.flags & clear_faults) != 0,
          static_cast<Mode>(r.mode),
          S(r.setpoint),
          {S(r.proportional), S(r.integral), S(r.derivative)}};
}

template <class S>
StepOutputs pack(const Output<S>& out) {
  const auto f = [](S x) { return static_cast<float>(x); };
  return {f(out.drive_current_A),
          f(out.drive_voltage_V),
          f(out.reference),
          f(out.wanted_power_W),
          f(out.measurement.resistance_ohm),
          f(out.estimate.strain),
          f(out.estimate.strain_sd),
          f(out.estimate.temperature_K),
          f(out.estimate.martensite),
          f(out.estimated_ambient_K),
          f(out.hot_spot_K),
          static_cast<std::uint32_t>(out.state),
          static_cast<std::uint32_t>(out.mode),
          out.limit_reasons,
          low(out.latched.bits()),
          high(out.latched.bits())};
}

/// A step as the file wants it.
template <class S>
StepOutputs step(const Prepared<S>& prepared, typename Device<S>::State& state,
                 const StepInputs& r) {
  if ((r.flags & restart) != 0) {
    state = Device<S>::start();
  }
  return pack(Device<S>::step(prepared, state, inputs_of<S>(r), command_of<S>(r), S(r.dt_s)));
}

}  // namespace smaservo::mcu
