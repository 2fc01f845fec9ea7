// The device, its sensors and its output stage on a wire of one temperature: what `host-sim
// simulate` does with the plant `lumped` and a constant load, to the same bits.

#include <cmath>
#include <type_traits>

#include "firmware/cycle.hpp"
#include "firmware/device/device.hpp"
#include "firmware/parameters/parameter_check.hpp"
#include "hal/sim/front_end.hpp"
#include "host-sim/fmu/unit/check.hpp"
#include "host-sim/fmu/unit/component.hpp"
#include "host-sim/fmu/unit/servo_variables.hpp"
#include "model/wire/wire_plant.hpp"

namespace smaservo::fmu::unit {
namespace {

/// Nanoseconds in 64 bits.
constexpr double longest_time_s = 9e9;
/// As hal::SimBoard divides a period.
constexpr std::int64_t longest_part_ns = 1'000'000;

/// What the parameters say.
struct ServoSetup {
  Settings<double> settings;
  Wire<double> wire;
  hal::Converter converter;
  hal::Sensors sensors;
  std::uint64_t seed;
  bool reads_supply, reads_ambient, reads_driver;
  double driver_above_K;
};

/// All that is remembered.
struct ServoMemory {
  WirePlant<double> plant;
  hal::FrontEnd front_end;
  Device<double>::State device;
  hal::DriveCommand command;
  std::int64_t now_ns;  ///< since the beginning
  std::int64_t ticks;   ///< cycles of the device that were made; the next is at ticks periods
};
static_assert(std::is_trivially_copyable_v<ServoMemory>);

/// The surfaces of the wire in the device's settings, and of the wire that it drives.
struct ServoSurfaces {
  Surfaces device, plant;
};

/// Of values that are allowed.
ServoSetup setup_of(const std::vector<double>& from, ServoSurfaces surfaces) {
  ServoSetup setup{};
  std::size_t next = servo_parameters_at;
  setup.settings = read_settings(from, next, surfaces.device);
  const double* const board = &from[next];
  const auto value = [&](BoardParameter p) { return board[static_cast<std::size_t>(p)]; };
  using enum BoardParameter;
  setup.sensors = {.bits = static_cast<int>(value(bits)),
                   .current_full_scale_A = value(current_full_scale_A),
                   .voltage_full_scale_V = value(voltage_full_scale_V),
                   .load_full_scale_N = value(load_full_scale_N),
                   .current_noise_A = value(current_noise_A),
                   .voltage_noise_V = value(voltage_noise_V),
                   .load_noise_N = value(load_noise_N),
                   .load_gain = value(load_gain),
                   .resistance_gain = value(resistance_gain)};
  setup.seed = static_cast<std::uint64_t>(value(seed));
  setup.reads_supply = value(reads_supply) != 0;
  setup.reads_ambient = value(reads_ambient) != 0;
  setup.reads_driver = value(reads_driver) != 0;
  setup.driver_above_K = value(driver_above_K);
  setup.converter = {.voltage_drive = setup.settings.drive.kind == DriveKind::voltage,
                     .max_A = value(max_A),
                     .slew_A_s = value(slew_A_s),
                     .lead_ohm = value(lead_ohm)};
  next += static_cast<std::size_t>(BoardParameter::count);
  setup.wire = read_wire(from, next, surfaces.plant);
  return setup;
}

/// "" or what is wrong with the values, whose reals of the device are rounded to float.
std::string wrong_servo(const std::vector<Variable>& variables, std::vector<double>& values,
                        ServoSurfaces surfaces) {
  round_settings(values, servo_parameters_at, surfaces.device);
  std::string problem = wrong_value(variables, values);
  if (!problem.empty()) {
    return problem;
  }
  const ServoSetup setup = setup_of(values, surfaces);
  const Finding found = check(setup.settings);
  if (!found.ok()) {
    problem = std::string(parameters<double>[found.parameter].path.text());
    if (found.problem != Problem::contradiction) {
      return problem + " is out of its range";
    }
    return problem + " and " + std::string(parameters<double>[found.other].path.text()) +
           " contradict each other: " + std::string(parameter_rules[found.rule].meaning);
  }
  return wrong_wire(setup.wire, "true.");
}

class ServoComponent : public Component {
 public:
  /// With values in which nothing is wrong.
  ServoComponent(std::vector<Variable> variables, std::vector<double> start, ServoSurfaces surfaces)
      : Component(std::move(variables), std::move(start)),
        surfaces_(surfaces),
        setup_(setup_of(values, surfaces)),
        prepared_(prepare(setup_.settings)),
        memory_(at_rest(setup_)) {
    count_period();
  }

  std::string begin() override {
    std::vector<double> rounded = values;
    std::string problem = wrong_servo(variables(), rounded, surfaces_);
    if (!problem.empty()) {
      return problem;
    }
    const ServoSetup setup = setup_of(rounded, surfaces_);
    const ServoMemory memory = at_rest(setup);
    if (!is_made(memory.plant.output())) {
      return "the wire has no state of rest under this load_N at this ambient_K";
    }
    values = rounded;
    setup_ = setup;
    prepared_ = prepare(setup_.settings);
    memory_ = memory;
    count_period();
    show();
    return "";
  }

  std::string advance(double to_s, double /*step_s*/) override {
    if (longest_time_s < to_s) {
      return "the time is more than " + shown(longest_time_s) +
             " s from the beginning, beyond the clock of the device";
    }
    const std::int64_t end_ns = std::llround(to_s * 1e9);
    const ServoMemory before = memory_;
    while (memory_.now_ns < end_ns) {
      if (memory_.now_ns == memory_.ticks * period_ns_) {
        tick();
      }
      if (!advance_part(end_ns)) {
        memory_ = before;
        return "the step has no finite result: load_N or a parameter is far beyond what a wire can "
               "bear";
      }
    }
    show();
    return "";
  }

  std::span<std::byte> memory() override { return std::as_writable_bytes(std::span(&memory_, 1)); }

  void restored() override {
    setup_ = setup_of(values, surfaces_);
    prepared_ = prepare(setup_.settings);
    count_period();
  }

 private:
  double input(ServoInput which) const {
    return values[servo_inputs_at + static_cast<std::size_t>(which)];
  }

  ServoMemory at_rest(const ServoSetup& setup) const {
    return {.plant = WirePlant<double>(setup.wire, input(ServoInput::load_N),
                                       input(ServoInput::ambient_K)),
            .front_end = hal::FrontEnd(setup.converter, setup.sensors, setup.seed),
            .device = Device<double>::start(),
            .command = {},
            .now_ns = 0,
            .ticks = 0};
  }

  void count_period() {
    period_ns_ = std::llround(setup_.settings.timing.period_s * 1e9);
    parts_ = (period_ns_ + longest_part_ns - 1) / longest_part_ns;
    part_s_ = static_cast<double>(period_ns_) * 1e-9 / static_cast<double>(parts_);
  }

  void set_faults() {
    const auto sensor = [&](hal::Reading reading, ServoInput fails) {
      memory_.front_end.faults.sensors[static_cast<std::size_t>(reading)].fault =
          input(fails) != 0 ? hal::SensorFault::missing : hal::SensorFault::none;
    };
    sensor(hal::Reading::current, ServoInput::current_fails);
    sensor(hal::Reading::voltage, ServoInput::voltage_fails);
    sensor(hal::Reading::load, ServoInput::load_fails);
    memory_.front_end.faults.circuit = static_cast<hal::Circuit>(input(ServoInput::circuit));
    memory_.front_end.faults.emergency_stop = input(ServoInput::emergency_stop) != 0;
  }

  /// One cycle of the device: readings, step, command to the drive.
  void tick() {
    ServoMemory& m = memory_;
    set_faults();
    constexpr double none = std::numeric_limits<double>::quiet_NaN();
    const double ambient_K = input(ServoInput::ambient_K);
    hal::Frame frame{};
    frame.time_ns = m.now_ns;
    frame.sequence = static_cast<std::uint32_t>(m.ticks);
    const bool came = m.front_end.read(
        {.wire_ohm = m.plant.output().resistance_ohm,
         .load_N = input(ServoInput::load_N),
         .supply_V = setup_.reads_supply ? input(ServoInput::supply_V) : none,
         .ambient_K = setup_.reads_ambient ? ambient_K : none,
         .driver_K = setup_.reads_driver ? ambient_K + setup_.driver_above_K : none},
        frame);
    const auto mode = static_cast<Mode>(input(ServoInput::mode));
    const Command<double> command{.fresh = true,
                                  .arm = input(ServoInput::enable) != 0 && mode != Mode::off,
                                  .clear_faults = input(ServoInput::clear_faults) != 0,
                                  .mode = mode,
                                  .setpoint = input(ServoInput::setpoint)};
    const double dt_s =
        m.ticks == 0 ? setup_.settings.timing.period_s : static_cast<double>(period_ns_) * 1e-9;
    const Output<double> out = Device<double>::step(
        prepared_, m.device,
        inputs_of<double>(frame, came ? hal::ReadStatus::frame : hal::ReadStatus::nothing), command,
        dt_s);
    ++m.ticks;
    m.command = {out.drive_current_A, out.drive_voltage_V, m.ticks * period_ns_};
  }

  /// Advances the wire to the end of the part of the period, or to end_ns if that is earlier.
  bool advance_part(std::int64_t end_ns) {
    ServoMemory& m = memory_;
    set_faults();
    const std::int64_t began_ns = (m.ticks - 1) * period_ns_;
    std::int64_t part = 1;
    while (began_ns + period_ns_ * part / parts_ <= m.now_ns) {
      ++part;
    }
    const std::int64_t part_ends_ns = began_ns + period_ns_ * part / parts_;
    const bool whole =
        part_ends_ns <= end_ns && m.now_ns == began_ns + period_ns_ * (part - 1) / parts_;
    const std::int64_t to_ns = part_ends_ns < end_ns ? part_ends_ns : end_ns;
    const double dt_s = whole ? part_s_ : static_cast<double>(to_ns - m.now_ns) * 1e-9;
    const double current_A = m.front_end.advance(&m.command, input(ServoInput::supply_V),
                                                 m.plant.output().resistance_ohm, dt_s);
    const bool torn = m.front_end.faults.circuit == hal::Circuit::broken;
    m.now_ns = to_ns;
    return is_made(m.plant.update({.current_A = current_A,
                                   .load_N = torn ? 0 : input(ServoInput::load_N),
                                   .ambient_K = input(ServoInput::ambient_K),
                                   .draught = input(ServoInput::draught)},
                                  dt_s));
  }

  void show() {
    const WireOutput<double> wire = memory_.plant.output();
    const Output<double>& out = memory_.device.last;
    double* to = &values[servo_outputs_at];
    show_wire(wire, setup_.wire.geometry.length_m, to);
    to += wire_state_count;
    const auto put = [&](ServoOutput which, double value) {
      to[static_cast<std::size_t>(which)] = value;
    };
    using enum ServoOutput;
    const double true_A = memory_.front_end.current_A();
    put(current_A, true_A);
    put(voltage_V, true_A * wire.resistance_ohm);
    put(power_W, true_A * true_A * wire.resistance_ohm);
    put(drive_current_A, out.drive_current_A);
    put(estimated_strain, out.estimate.strain);
    put(estimated_strain_sd, out.estimate.strain_sd);
    put(estimated_displacement_m, out.estimate.strain * setup_.settings.wire.geometry.length_m);
    put(estimated_temperature_K, out.estimate.temperature_K);
    put(estimated_ambient_K, out.estimated_ambient_K);
    put(hot_spot_K, out.hot_spot_K);
    put(state, static_cast<double>(out.state));
    put(mode, static_cast<double>(out.mode));
    put(setpoint, out.setpoint);
    put(reference, out.reference);
    put(wanted_power_W, out.wanted_power_W);
    put(limit_reasons, out.limit_reasons);
    put(cycles, static_cast<double>(memory_.ticks));
    put(first_cause, static_cast<double>(out.first_cause));
    auto word = static_cast<std::size_t>(latched);
    for (const FaultSet set : {out.latched, out.warnings, out.blocks}) {
      for (unsigned i = 0; i < fault_words; ++i) {
        constexpr std::uint64_t mask = (std::uint64_t{1} << faults_in_word) - 1;
        to[word++] = static_cast<double>(set.bits() >> (i * faults_in_word) & mask);
      }
    }
  }

  ServoSurfaces surfaces_;
  ServoSetup setup_;
  Prepared<double> prepared_;
  ServoMemory memory_;
  std::int64_t period_ns_ = 0, parts_ = 1;
  double part_s_ = 0;
};

}  // namespace

std::unique_ptr<Component> make_component(Constants& constants) {
  const Surfaces device{constants.take("separate_r2a") != 0, constants.take("separate_r2m") != 0};
  const Surfaces plant{constants.take("true.separate_r2a") != 0,
                       constants.take("true.separate_r2m") != 0};
  std::vector<Variable> variables = servo_variables(device, plant);
  std::vector<double> start = start_values(variables, constants);
  const std::string problem = wrong_servo(variables, start, {device, plant});
  if (!problem.empty()) {
    throw ConstantsError(problem);
  }
  return std::make_unique<ServoComponent>(std::move(variables), std::move(start),
                                          ServoSurfaces{device, plant});
}

const char* component_kind() {
  return "servo";
}

}  // namespace smaservo::fmu::unit
