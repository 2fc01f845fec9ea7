#pragma once
// The parameters of the device itself: everything but its wire.

#include "firmware/parameters/parameter.hpp"
#include "model/units.hpp"

namespace smaservo {

inline constexpr std::string_view drive_names[] = {"current", "voltage"};
inline constexpr std::string_view safe_names[] = {"off", "hold", "release"};

template <class S>
constexpr auto identity_rows() {
  constexpr auto g = &Settings<S>::identity;
  return std::to_array<Parameter<S>>({
      number<Member<S, g, &Identity::serial_number>>({0x2000, 1}, "identity.serial_number",
                                                     Change::after_reset, 0, 0, 0xFFFFFFFF,
                                                     "serial number, which 1018h:4 and LSS report"),
      number<Member<S, g, &Identity::node_id>>({0x2000, 2}, "identity.node_id", Change::after_reset,
                                               1, 1, 127, "node-id on the CAN bus"),
  });
}

template <class S>
constexpr auto timing_rows() {
  constexpr auto g = &Settings<S>::timing;
  using G = Timing<S>;
  return std::to_array<Parameter<S>>({
      real<Member<S, g, &G::period_s>>({0x2001, 1}, "timing.period_s", kind::time,
                                       Change::after_reset, 1e-4F, 1e-3F, 0.02F,
                                       "period of the control loop"),
      real<Member<S, g, &G::command_timeout_s>>(
          {0x2001, 2}, "timing.command_timeout_s", kind::time, Change::without_current, 1e-3F, 0.1F,
          60, "time without a fresh command after which command_timeout is raised"),
      real<Member<S, g, &G::sample_timeout_s>>(
          {0x2001, 3}, "timing.sample_timeout_s", kind::time, Change::without_current, 2e-4F,
          0.005F, 0.1F, "time without a fresh sample after which sample_stale is raised"),
  });
}

template <class S>
constexpr auto measuring_rows() {
  constexpr auto g = &Settings<S>::measurement;
  using G = MeasurementSettings<S>;
  constexpr auto when = Change::without_current;
  return std::to_array<Parameter<S>>({
      real<Member<S, g, &G::current_offset_A>>(
          {0x2010, 1}, "measurement.current_offset_A", kind::current, when, -1, 0, 1,
          "reading at zero current; subtracted from each reading"),
      real<Member<S, g, &G::voltage_offset_V>>(
          {0x2010, 2}, "measurement.voltage_offset_V", kind::voltage, when, -1, 0, 1,
          "reading at zero voltage; subtracted from each reading"),
      real<Member<S, g, &G::load_offset_N>>({0x2010, 3}, "measurement.load_offset_N", kind::force,
                                            when, -1e4F, 0, 1e4F,
                                            "reading without load; subtracted from each reading"),
      real<Member<S, g, &G::load_gain>>(
          {0x2010, 4}, "measurement.load_gain", kind::number, when, -100, 1, 100,
          "factor on the load reading after its offset is subtracted"),
      real<Member<S, g, &G::current_noise_A>>(
          {0x2010, 5}, "measurement.current_noise_A", kind::current, when, 0, 1e-5F, 1,
          "standard deviation of the noise of a current reading"),
      real<Member<S, g, &G::voltage_noise_V>>(
          {0x2010, 6}, "measurement.voltage_noise_V", kind::voltage, when, 0, 3e-4F, 1,
          "standard deviation of the noise of a voltage reading"),
      real<Member<S, g, &G::lead_resistance_ohm>>(
          {0x2010, 7}, "measurement.lead_resistance_ohm", kind::resistance, when, 0, 0, 100,
          "resistance of the leads that the measured voltage includes; 0 with four wires"),
      real<Member<S, g, &G::constant_load_N>>({0x2010, 8}, "measurement.constant_load_N",
                                              kind::force, when, 0, 0, 1e4F,
                                              "load to assume where there is no load cell"),
      boolean<Member<S, g, &G::has_load_cell>>(
          {0x2010, 9}, "measurement.has_load_cell", when, true,
          "true: the load is measured; false: it is measurement.constant_load_N"),
      real<Member<S, g, &G::current_full_scale_A>>(
          {0x2010, 10}, "measurement.current_full_scale_A", kind::current, when, 1e-3F, 0.5F, 100,
          "a current reading at or beyond it counts as saturated"),
      real<Member<S, g, &G::voltage_full_scale_V>>(
          {0x2010, 11}, "measurement.voltage_full_scale_V", kind::voltage, when, 0.01F, 20, 1000,
          "a voltage reading at or beyond it counts as saturated"),
  });
}

template <class S>
constexpr auto observer_rows() {
  constexpr auto g = &Settings<S>::observer;
  using G = ObserverSettings<S>;
  constexpr auto when = Change::without_current;
  return std::to_array<Parameter<S>>({
      real<Member<S, g, &G::start_ambient_sd_K>>(
          {0x2011, 1}, "observer.start_ambient_sd_K", kind::temperature_difference, when, 0.1F, 18,
          100, "standard deviation of the ambient temperature that the observer starts from"),
      real<Member<S, g, &G::start_loss_sd>>({0x2011, 2}, "observer.start_loss_sd", kind::number,
                                            when, 0.01F, 0.3F, 2,
                                            "standard deviation of the heat loss that the observer "
                                            "starts from, relative to the wire file's"),
  });
}

template <class S>
constexpr auto limit_rows() {
  constexpr auto g = &Settings<S>::limits;
  using G = SoftLimits<S>;
  constexpr auto live = Change::live;
  return set_up(std::to_array<Parameter<S>>({
      real<Member<S, g, &G::min_current_A>>(
          {0x2020, 1}, "limits.min_current_A", kind::current, live, 1e-4F, 0.01F, 20,
          "minimum current while running, which keeps the resistance measurable"),
      real<Member<S, g, &G::current_A>>({0x2020, 2}, "limits.current_A", kind::current, live, 1e-3F,
                                        0.1F, 20, "maximum current"),
      real<Member<S, g, &G::power_W>>({0x2020, 3}, "limits.power_W", kind::power, live, 1e-3F, 2,
                                      1000, "maximum electrical power into the wire"),
      real<Member<S, g, &G::temperature_K>>({0x2020, 4}, "limits.temperature_K", kind::temperature,
                                            live, static_cast<float>(zero_degC_K), 393.15F, 600,
                                            "maximum temperature of the wire's hottest spot"),
      real<Member<S, g, &G::hot_spot_K>>(
          {0x2020, 5}, "limits.hot_spot_K", kind::temperature_difference, live, 0, 18, 100,
          "how far the hottest spot may lie above the estimated temperature"),
      real<Member<S, g, &G::min_strain>>({0x2020, 6}, "limits.min_strain", kind::number, live,
                                         -0.05F, 0, 0.2F,
                                         "smallest strain asked for: the wire at its shortest"),
      real<Member<S, g, &G::max_strain>>({0x2020, 7}, "limits.max_strain", kind::number, live,
                                         -0.05F, 0.05F, 0.2F,
                                         "largest strain asked for: the wire at its longest"),
      real<Member<S, g, &G::stress_Pa>>({0x2020, 8}, "limits.stress_Pa", kind::stress, live, 1e6F,
                                        150e6F, 2e9F,
                                        "stress above which no more contraction is asked for"),
      real<Member<S, g, &G::duty>>({0x2020, 9}, "limits.duty", kind::number, live, 0.01F, 1, 1,
                                   "maximum mean square of the current, as a share of "
                                   "limits.current_A squared; 1: no limit"),
      real<Member<S, g, &G::duty_window_s>>({0x2020, 10}, "limits.duty_window_s", kind::time, live,
                                            0.1F, 10, 3600, "time constant of that mean"),
      real<Member<S, g, &G::loss_margin>>({0x2020, 11}, "limits.loss_margin", kind::number, live, 1,
                                          1.15F, 100,
                                          "largest heat loss that the temperature limit reckons "
                                          "with, as a multiple of the wire file's"),
  }));
}

template <class S>
constexpr auto trip_rows() {
  constexpr auto g = &Settings<S>::trips;
  using G = TripLimits<S>;
  constexpr auto when = Change::without_current;
  return std::to_array<Parameter<S>>({
      real<Member<S, g, &G::current_A>>({0x2021, 1}, "trips.current_A", kind::current, when, 1e-3F,
                                        0.15F, 25,
                                        "measured current above which over_current is raised"),
      real<Member<S, g, &G::temperature_K>>({0x2021, 2}, "trips.temperature_K", kind::temperature,
                                            when, static_cast<float>(zero_degC_K), 403.15F, 650,
                                            "temperature of the hottest spot above which "
                                            "over_temperature or overheat_signature is raised"),
      real<Member<S, g, &G::stress_Pa>>({0x2021, 3}, "trips.stress_Pa", kind::stress, when, 1e6F,
                                        200e6F, 3e9F, "stress above which over_stress is raised"),
      real<Member<S, g, &G::slack_Pa>>({0x2021, 4}, "trips.slack_Pa", kind::stress, when, -1e8F,
                                       1e6F, 2e9F, "stress below which load_lost is raised"),
      real<Member<S, g, &G::min_strain>>(
          {0x2021, 5}, "trips.min_strain", kind::number, when, -0.1F, -0.005F, 0.25F,
          "strain below which over_strain is raised: the wire is too short"),
      real<Member<S, g, &G::max_strain>>(
          {0x2021, 6}, "trips.max_strain", kind::number, when, -0.1F, 0.06F, 0.25F,
          "strain above which over_strain is raised: the wire is too long"),
      real<Member<S, g, &G::following_error>>({0x2021, 7}, "trips.following_error", kind::number,
                                              when, 1e-4F, 0.01F, 0.2F,
                                              "deviation of the strain from its reference that "
                                              "raises following_error after trips.following_s"),
      real<Member<S, g, &G::following_s>>({0x2021, 8}, "trips.following_s", kind::time, when, 0.01F,
                                          2, 600, "how long that deviation may last"),
      real<Member<S, g, &G::heating_rate_K_s>>(
          {0x2021, 9}, "trips.heating_rate_K_s", kind::heating_rate, when, 1, 1e4F, 1e6F,
          "rise of the temperature above which heating_rate is raised"),
      real<Member<S, g, &G::resistance_low>>({0x2021, 10}, "trips.resistance_low", kind::number,
                                             when, 0.05F, 0.8F, 0.99F,
                                             "smallest cold resistance at arming, relative to the "
                                             "wire file's; below it: cold_resistance"),
      real<Member<S, g, &G::resistance_high>>({0x2021, 11}, "trips.resistance_high", kind::number,
                                              when, 1.01F, 1.2F, 20,
                                              "largest cold resistance at arming, relative to the "
                                              "wire file's; above it: cold_resistance"),
      real<Member<S, g, &G::current_offset_A>>(
          {0x2021, 12}, "trips.current_offset_A", kind::current, when, 1e-6F, 0.002F, 1,
          "reading while no current is given above which current_offset is raised"),
      real<Member<S, g, &G::min_ambient_K>>(
          {0x2021, 13}, "trips.min_ambient_K", kind::temperature, when, 173.15F, 253.15F, 400,
          "ambient temperature below which ambient_range is raised"),
      real<Member<S, g, &G::max_ambient_K>>(
          {0x2021, 14}, "trips.max_ambient_K", kind::temperature, when, 173.15F, 333.15F, 400,
          "ambient temperature above which ambient_range is raised"),
      real<Member<S, g, &G::driver_K>>(
          {0x2021, 15}, "trips.driver_K", kind::temperature, when, static_cast<float>(zero_degC_K),
          358.15F, 450, "temperature of the output stage above which driver_hot is raised"),
      real<Member<S, g, &G::drift>>(
          {0x2021, 16}, "trips.drift", kind::number, when, 1e-3F, 0.05F, 1,
          "relative deviation of the resistance from the wire file above which drift is raised"),
      number<Member<S, g, &G::cycles>>(
          {0x2021, 17}, "trips.cycles", when, 1, 100000, 0xFFFFFFFF,
          "full cycles of the wire after which the warning cycles is raised"),
  });
}

template <class S>
constexpr auto safe_rows() {
  constexpr auto g = &Settings<S>::safe;
  using G = SafeSettings<S>;
  constexpr auto when = Change::without_current;
  return std::to_array<Parameter<S>>({
      choice<Member<S, g, &G::state>>({0x2022, 1}, "safe.state", safe_names, when, SafeState::off,
                                      "safe state after a fault of class F2"),
      real<Member<S, g, &G::hold_s>>(
          {0x2022, 2}, "safe.hold_s", kind::time, when, 0, 0, 3600,
          "hold: how long the strain is held before the current goes off"),
      real<Member<S, g, &G::release_1_s>>(
          {0x2022, 3}, "safe.release_1_s", kind::rate, when, 1e-5F, 0.01F, 10,
          "release: strain rate at which the wire may stretch before the current goes off"),
  });
}

template <class S>
constexpr auto axis_rows() {
  return std::to_array<Parameter<S>>({
      real<Member<S, &Settings<S>::axis, &PositionSettings<S>::zero_strain>>(
          {0x2030, 1}, "axis.zero_strain", kind::number, Change::without_current, -0.05F, 0.04F,
          0.2F, "strain at position 0, from which positions count contraction"),
      real<Member<S, &Settings<S>::axis, &PositionSettings<S>::stop_strain>>(
          {0x2030, 2}, "axis.stop_strain", kind::number, Change::without_current, 0, 0, 0.2F,
          "strain at which a hard stop ends the contraction; set too high rather than too low; "
          "0: no stop; ignored with a load cell"),
  });
}

/// Defaults that differ between the loops.
struct LoopDefaults {
  float proportional, integral_1_s, dead_band;
};

template <class S, auto g>
constexpr auto loop_rows(std::uint16_t x, const char* p, const char* gain_unit, Kind gain,
                         const char* band_unit, Kind band, LoopDefaults standard) {
  using G = LoopGains<S>;
  constexpr auto live = Change::live;
  return std::to_array<Parameter<S>>({
      real<Member<S, g, &G::proportional>>({x, 1}, {p, ".proportional_", gain_unit}, gain, live, 0,
                                           standard.proportional, 1e6F,
                                           "heating power per unit of the error"),
      real<Member<S, g, &G::integral_1_s>>({x, 2}, {p, ".integral_1_s"}, kind::rate, live, 0,
                                           standard.integral_1_s, 1000,
                                           "integral gain per proportional gain: 1/T_i"),
      real<Member<S, g, &G::derivative_s>>({x, 3}, {p, ".derivative_s"}, kind::time, live, 0, 0, 10,
                                           "derivative gain per proportional gain: T_d"),
      real<Member<S, g, &G::derivative_filter_s>>(
          {x, 4}, {p, ".derivative_filter_s"}, kind::time, live, 0, 0.005F, 10,
          "time constant of the filter on the controlled variable for the derivative part"),
      real<Member<S, g, &G::setpoint_weight>>({x, 5}, {p, ".setpoint_weight"}, kind::number, live,
                                              0, 1, 1,
                                              "weight of the set-point in the proportional part"),
      real<Member<S, g, &G::derivative_weight>>({x, 6}, {p, ".derivative_weight"}, kind::number,
                                                live, 0, 0, 1,
                                                "weight of the set-point in the derivative part"),
      real<Member<S, g, &G::tracking_s>>({x, 7}, {p, ".tracking_s"}, kind::time, live, 1e-4F, 0.05F,
                                         100,
                                         "time constant of the anti-windup by back-calculation"),
      real<Member<S, g, &G::cooling_factor>>(
          {x, 8}, {p, ".cooling_factor"}, kind::number, live, 0.01F, 1, 100,
          "factor on the proportional and integral gain while less heat is asked for"),
      real<Member<S, g, &G::dead_band>>({x, 9}, {p, ".dead_band", band_unit}, band, live, 0,
                                        standard.dead_band, 1000,
                                        "half width of the dead band around the reference"),
  });
}

template <class S>
constexpr auto drive_rows() {
  constexpr auto g = &Settings<S>::drive;
  using G = DriveSettings<S>;
  constexpr auto when = Change::without_current;
  // The correction may exceed the wanted current by a tenth, which is a fifth more power.
  return set_up(std::to_array<Parameter<S>>({
      choice<Member<S, g, &G::kind>>({0x2101, 1}, "drive.kind", drive_names, when,
                                     DriveKind::current,
                                     "quantity that the output stage is commanded in"),
      real<Member<S, g, &G::proportional>>(
          {0x2101, 2}, "drive.proportional", kind::number, Change::live, 0, 0, 100,
          "proportional gain of the current loop: correction per missing current"),
      real<Member<S, g, &G::integral_1_s>>({0x2101, 3}, "drive.integral_1_s", kind::rate,
                                           Change::live, 0, 0, 1e5F,
                                           "integral gain of the current loop"),
      real<Member<S, g, &G::min_supply_V>>({0x2101, 4}, "drive.min_supply_V", kind::voltage, when,
                                           0, 5, 1000,
                                           "supply voltage below which supply_low is raised"),
      real<Member<S, g, &G::max_supply_V>>({0x2101, 5}, "drive.max_supply_V", kind::voltage, when,
                                           0, 30, 1000,
                                           "supply voltage above which supply_high is raised"),
  }));
}

template <class S>
constexpr auto trajectory_rows() {
  constexpr auto g = &Settings<S>::trajectory;
  using G = TrajectorySettings<S>;
  return std::to_array<Parameter<S>>({
      real<Member<S, g, &G::heating_rate_1_s>>(
          {0x2106, 1}, "trajectory.heating_rate_1_s", kind::rate, Change::live, 1e-5F, 0.6F, 100,
          "maximum strain rate of the reference while contracting"),
      real<Member<S, g, &G::cooling_rate_1_s>>(
          {0x2106, 2}, "trajectory.cooling_rate_1_s", kind::rate, Change::live, 1e-5F, 1, 100,
          "maximum strain rate of the reference while stretching; it waits for a wire that cools "
          "more slowly"),
      real<Member<S, &Settings<S>::feed_forward_s>>(
          {0x2106, 3}, "trajectory.feed_forward_s", kind::time, Change::live, 0, 0.01F, 60,
          "time in which the feed-forward brings the wire to its reference; 0: it only replaces "
          "the heat lost"),
      real<Member<S, &Settings<S>::transfer_s>>(
          {0x2106, 4}, "trajectory.transfer_s", kind::time, Change::live, 0, 0.01F, 60,
          "time constant with which a new mode or gain takes over"),
      real<Member<S, g, &G::lead_s>>(
          {0x2106, 5}, "trajectory.lead_s", kind::time, Change::live, 0, 0.05F, 1,
          "time by which a streaming set-point is led, against the wire's delay"),
  });
}

template <class S>
constexpr auto profile_rows() {
  constexpr auto g = &Settings<S>::profile;
  using G = ProfileSettings<S>;
  constexpr auto live = Change::live;
  return std::to_array<Parameter<S>>({
      real<Member<S, g, &G::overheat_K>>(
          {0x2107, 1}, "profile.overheat_K", kind::temperature_difference, live, 0, 12, 100,
          "how far the profile heats above the end of the transformation"),
      real<Member<S, g, &G::cycle_s>>({0x2107, 2}, "profile.cycle_s", kind::time, live, 0.05F, 5,
                                      3600, "duration of a full cycle"),
      real<Member<S, g, &G::loop_s>>({0x2107, 3}, "profile.loop_s", kind::time, live, 0.02F, 1.5F,
                                     3600, "duration of an inner loop"),
  });
}

}  // namespace smaservo
