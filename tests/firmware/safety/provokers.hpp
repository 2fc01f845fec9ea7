#pragma once
// A way to provoke each fault on a simulated wire.

#include <vector>

#include "tests/firmware/device/rig.hpp"

namespace smaservo {

struct Provoker {
  Fault fault;
  std::function<void(Rig&)> cause;
  std::function<void(Settings<double>&)> change = [](Settings<double>&) {};
  /// Time until the condition of the fault is present: heating, a filter, a counter.
  double within_s = 0;
  /// Time without current before arming, for faults that come before arming.
  double before_s = 0;
};

using Readings = Inputs<double>;

/// A cause that changes the readings in the same way from now on.
inline std::function<void(Rig&)> reading(std::function<void(Readings&)> change) {
  return [change](Rig& rig) { rig.tamper_inputs = change; };
}
/// A cause that makes another current flow than the one given.
inline std::function<void(Rig&)> driving(std::function<double(double)> flowing) {
  return [flowing](Rig& rig) { rig.tamper_drive = flowing; };
}
inline std::function<void(Rig&)> reported(Fault fault) {
  return reading([fault](Readings& in) { in.external = fault; });
}
inline constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();
inline double while_given(double given_A, double flowing_A) {
  return given_A > 0 ? flowing_A : 0;
}

/// Commands this power. The device gives it, up to its limits, whatever the state of the wire.
inline void give_power(Rig& rig, double power_W) {
  rig.command.mode = Mode::power;
  rig.command.setpoint = power_W;
}
inline void give_current(Rig& rig, double current_A) {
  rig.command.mode = Mode::current;
  rig.command.setpoint = current_A;
}
inline constexpr double all_W = 10;
/// Value of limits.loss_margin that raises the limit of the sustained power so far that it never
/// acts. If limits.min_strain is also set to a strain that the wire cannot reach, only the
/// temperature limit bounds the heat.
inline constexpr double heats_for_long = 20;

/// Delay of a drive's fault, which begins when the current of the first step flows.
inline constexpr double late_s = 0.001;

inline std::vector<Provoker> drive_provokers() {
  return {
      {Fault::supply_low, [](Rig& rig) { rig.supply_V = 3; }},
      {Fault::supply_high, [](Rig& rig) { rig.supply_V = 40; }},
      {Fault::over_current, driving([](double A) { return while_given(A, 0.47); })},
      {Fault::current_saturated, driving([](double A) { return while_given(A, 0.6); }),
       [](Settings<double>& s) { s.trips.current_A = 1; }},
      {Fault::voltage_saturated, reading([](Readings& in) { in.sample.voltage_V = 20; })},
      {Fault::current_offset, reading([](Readings& in) { in.sample.current_A += 0.003; })},
      {Fault::current_control, driving([](double A) { return 0.5 * A; }), {}, late_s},
      {Fault::current_while_off, driving([](double A) { return std::max(A, 0.03); })},
      {Fault::driver_fault, reading([](Readings& in) { in.driver_fault = true; })},
      {Fault::driver_warm, reading([](Readings& in) { in.driver_K = 352; })},
      {Fault::driver_hot, reading([](Readings& in) { in.driver_K = 360; })},
      {Fault::kelvin_mismatch,
       // A crimp of 40 ohm takes most of the chopper's voltage.
       [](Rig& rig) {
         give_power(rig, rig.out.wanted_power_W);
         rig.tamper_drive = [&rig](double A) {
           return A > 0 ? rig.out.drive_voltage_V / (rig.wire->resistance_ohm() + 40) : 0;
         };
       },
       [](Settings<double>& s) { s.drive.kind = DriveKind::voltage; }, late_s},
  };
}

inline std::vector<Provoker> circuit_provokers() {
  return {
      {Fault::wire_open,
       [](Rig& rig) {
         rig.tamper_drive = [](double) { return 0; };
         rig.tamper_inputs = [&rig](Readings& in) {
           in.sample.voltage_V = rig.out.drive_current_A > 0 ? 20 : 0;
         };
       }},
      {Fault::wire_short, reading([](Readings& in) { in.sample.voltage_V *= 0.3; })},
      {Fault::sense_lead_open, reading([](Readings& in) { in.sample.voltage_V = 1e-4; })},
      {Fault::resistance_jump, reading([](Readings& in) { in.sample.voltage_V *= 0.88; })},
      // The sense leads are on a resistor of 24 ohm, like the cold wire, and not on the wire.
      {Fault::no_response,
       [](Rig& rig) {
         give_power(rig, all_W);
         rig.tamper_inputs = [](Readings& in) { in.sample.voltage_V = 24 * in.sample.current_A; };
       },
       [](Settings<double>& s) {
         s.limits.loss_margin = heats_for_long;
         s.limits.min_strain = -0.05;
         s.limits.temperature_K = 450;
         s.trips.temperature_K = 460;
       },
       0.06},
  };
}

/// Gives all power. After 0.9 s, when the wire is wholly austenite and the cooling has been tested,
/// the resistance rises at once by this factor.
inline std::function<void(Rig&)> resistance_rises(double factor) {
  return [factor](Rig& rig) {
    give_power(rig, all_W);
    rig.tamper_inputs = [&rig, factor, start = rig.steps](Readings& in) {
      in.sample.voltage_V *= rig.steps - start > 900 ? factor : 1;
    };
  };
}

inline std::vector<Provoker> heat_provokers() {
  const auto contract = [](Rig& rig) { rig.command.setpoint = 0.004; };
  const auto gentle = [](Settings<double>& s) {
    s.limits.current_A = 0.15;
    s.limits.loss_margin = heats_for_long;
    s.limits.min_strain = -0.05;
    s.trips.heating_rate_K_s = 2000;
  };
  const auto full_power = [](Rig& rig) {
    rig.prepared.settings.limits.current_A = 0.4;
    give_power(rig, all_W);
  };
  const auto allow_hotter = [](Settings<double>& s) {
    s.limits.min_strain = -0.05;
    s.trips.following_error = 1;
  };
  return {
      {Fault::over_temperature, contract, [](Settings<double>& s) { s.trips.temperature_K = 385; },
       0.1},
      // The observer's temperature is lower than that of the heat balance.
      {Fault::heat_limit,
       [](Rig& rig) {
         rig.tamper_estimate = [](Estimate<double>& e) { e.temperature_K -= 25; };
         give_power(rig, all_W);
       },
       [](Settings<double>& s) {
         s.limits.temperature_K = 385;
         s.limits.loss_margin = heats_for_long;
         s.limits.min_strain = -0.05;
       },
       0.1},
      {Fault::overheat_onset, resistance_rises(1.008), allow_hotter, 0.95},
      // The resistance rises, and the driver does not lower its current any more.
      {Fault::overheat_signature,
       [](Rig& rig) {
         resistance_rises(1.013)(rig);
         rig.tamper_drive = [&rig, start = rig.steps, max_A = 0.0](double A) mutable {
           max_A = rig.steps - start > 880 ? std::min(std::max(max_A, A), 0.15) : 0;
           return while_given(A, std::max(A, max_A));
         };
       },
       allow_hotter, 0.95},
      // The wire is cooled too little; the guard's first test shows this.
      {Fault::cooling_weak,
       [](Rig& rig) {
         rig.draught = 0.4;
         give_power(rig, all_W);
       },
       allow_hotter, 2},
      {Fault::cooling_lost,
       [](Rig& rig) {
         rig.tamper_command = [&rig](Command<double>&) {
           rig.state.monitor.wire.cooling.told.verdict = CoolingGuard<double>::Verdict::overheated;
         };
       }},
      {Fault::heating_fast, full_power, gentle, 0.06},
      {Fault::heating_rate, full_power,
       [gentle](Settings<double>& s) {
         gentle(s);
         s.trips.heating_rate_K_s = 1500;
       },
       0.06},
  };
}

/// Lets the wire slip this number of times: its stress falls by a third, and a longer part of it
/// lies between the leads.
inline void slip(Rig& rig, int times) {
  const int start = rig.steps;
  const double held_Pa = rig.stress_Pa;
  rig.tamper_inputs = [&rig, start, held_Pa, times](Readings& in) {
    const int slips = std::min((rig.steps - start) / 150 + 1, times);
    const bool just_now = (rig.steps - start) % 150 < 30 && (rig.steps - start) / 150 < times;
    rig.stress_Pa = just_now ? 0.65 * held_Pa : held_Pa;
    in.sample.load_N = rig.load_N();
    in.sample.voltage_V *= 1 + 0.015 * slips;
  };
}

/// Commands full cycles of 2 s.
inline void go_to_and_fro(Rig& rig) {
  const int start = rig.steps;
  const double top = rig.wire->strain() + 0.012;
  rig.tamper_command = [&rig, start, top](Command<double>& c) {
    c.setpoint = (rig.steps - start) % 2000 < 1000 ? 0.008 : top;
  };
}

inline std::vector<Provoker> load_provokers() {
  return {
      {Fault::load_lost, [](Rig& rig) { rig.stress_Pa = 0.2e6; }, {}, 0.001},
      {Fault::over_stress, [](Rig& rig) { rig.stress_Pa = 650e6; }, {}, 0.001},
      {Fault::over_strain,
       [](Rig& rig) {
         rig.stress_Pa = 400e6;
         rig.command.setpoint = 0.06;
       },
       [](Settings<double>& s) { s.trips.max_strain = 0.045; }, 0.2},
      {Fault::slip_seen, [](Rig& rig) { slip(rig, 1); }, {}, 0.01},
      {Fault::clamp_slip, [](Rig& rig) { slip(rig, 3); }, {}, 0.32},
      {Fault::drift, [](Rig&) {},
       [](Settings<double>& s) {
         s.wire.geometry.length_m *= 0.96;
         s.trips.drift = 0.02;
       },
       1.5, 12},
      {Fault::cycles, go_to_and_fro, [](Settings<double>& s) { s.trips.cycles = 2; }, 6},
      {Fault::cold_resistance, [](Rig&) {},
       [](Settings<double>& s) { s.trips.resistance_high = 0.98; }, 0, 12},
      {Fault::duty,
       [](Rig& rig) {
         rig.tamper_command = [&rig](Command<double>&) { rig.state.controller.duty = 0.9; };
       },
       [](Settings<double>& s) { s.limits.duty = 0.5; }},
  };
}

inline std::vector<Provoker> estimate_provokers() {
  const auto estimate = [](std::function<void(Estimate<double>&)> change) {
    return [change](Rig& rig) { rig.tamper_estimate = change; };
  };
  return {
      // The resistance falls below that of any phase.
      {Fault::model_divergence,
       [](Rig& rig) {
         give_current(rig, rig.out.drive_current_A);
         // The fall is too slow for resistance_jump.
         rig.tamper_inputs = [&rig, start = rig.steps](Readings& in) {
           in.sample.voltage_V *= std::max(0.7, 1 - 0.004 * (rig.steps - start));
         };
       },
       [](Settings<double>& s) {
         s.limits.temperature_K = 590;
         s.trips.temperature_K = 600;
       },
       0.1},
      {Fault::estimate_invalid, estimate([](Estimate<double>& e) { e.strain = not_a_number; })},
      {Fault::estimate_unsure, estimate([](Estimate<double>& e) { e.health = Health::searching; })},
      // A current limit holds the wire back while the reference goes on at 0.35 1/s.
      {Fault::following_error, [](Rig& rig) { rig.prepared.settings.limits.current_A = 0.05; },
       [](Settings<double>& s) { s.trips.following_s = 0.3; }, 0.04},
      {Fault::power_balance,
       [](Rig& rig) {
         rig.draught = 0.5;
         go_to_and_fro(rig);
       },
       [](Settings<double>& s) { s.trips.following_error = 1; }, 20},
      {Fault::ambient_range, reading([](Readings& in) { in.ambient_K = 340; })},
      {Fault::started_outside, [](Rig& rig) { rig.stress_Pa = 550e6; }},
  };
}

inline std::vector<Provoker> machine_provokers() {
  return {
      {Fault::sensor_invalid, reading([](Readings& in) { in.sample.voltage_V = not_a_number; })},
      {Fault::sample_stale, reading([](Readings& in) { in.fresh = false; })},
      {Fault::sample_frozen, reading([](Readings& in) { in.sequence = 7; }), {}, 0.001},
      {Fault::control_invalid, [](Rig& rig) { rig.command.setpoint = not_a_number; }},
      {Fault::deadline_missed, reading([](Readings& in) { in.deadline_missed = true; }), {}, 0.01},
      {Fault::command_timeout, [](Rig& rig) { rig.command.fresh = false; }},
      {Fault::emergency_stop, reading([](Readings& in) { in.emergency_stop = true; })},
      // The current flows in pulses that are too short for current_while_off.
      {Fault::cooling_timeout,
       [](Rig& rig) {
         rig.tamper_drive = [&rig](double A) { return rig.steps % 20 == 0 ? 0.25 : A; };
       },
       {},
       14},
      {Fault::bus_lost, reported(Fault::bus_lost)},
      {Fault::duplicate_node, reported(Fault::duplicate_node)},
      {Fault::unclean_boot, reported(Fault::unclean_boot)},
      {Fault::store_corrupt, reported(Fault::store_corrupt)},
      {Fault::bad_configuration, reported(Fault::bad_configuration)},
      {Fault::not_configured, reported(Fault::not_configured)},
      {Fault::store_outdated, reported(Fault::store_outdated)},
      {Fault::loop_stalled, [](Rig& rig) { rig.stall(0.02); }},
  };
}

inline std::vector<Provoker> provokers() {
  std::vector<Provoker> all;
  for (const auto& some : {drive_provokers(), circuit_provokers(), heat_provokers(),
                           load_provokers(), estimate_provokers(), machine_provokers()}) {
    all.insert(all.end(), some.begin(), some.end());
  }
  return all;
}

/// Whether the device detects the fault while no current is given.
inline bool comes_while_off(Fault fault) {
  return fault_row(fault).severity == FaultClass::B || fault == Fault::current_while_off ||
         fault == Fault::cooling_timeout;
}

}  // namespace smaservo
