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
                                                     "of this device"),
      number<Member<S, g, &Identity::node_id>>({0x2000, 2}, "identity.node_id", Change::after_reset,
                                               1, 1, 127, "on the CAN bus"),
  });
}

template <class S>
constexpr auto timing_rows() {
  constexpr auto g = &Settings<S>::timing;
  using G = Timing<S>;
  return std::to_array<Parameter<S>>({
      real<Member<S, g, &G::period_s>>({0x2001, 1}, "timing.period_s", kind::time,
                                       Change::after_reset, 1e-4F, 1e-3F, 0.02F, "of the loop"),
      real<Member<S, g, &G::command_timeout_s>>({0x2001, 2}, "timing.command_timeout_s", kind::time,
                                                Change::without_current, 1e-3F, 0.1F, 60,
                                                "without a fresh command for so long: fault"),
      real<Member<S, g, &G::sample_timeout_s>>({0x2001, 3}, "timing.sample_timeout_s", kind::time,
                                               Change::without_current, 2e-4F, 0.005F, 0.1F,
                                               "without a fresh sample for so long: fault"),
  });
}

template <class S>
constexpr auto measuring_rows() {
  constexpr auto g = &Settings<S>::measuring;
  using G = Measuring<S>;
  constexpr auto when = Change::without_current;
  return std::to_array<Parameter<S>>({
      real<Member<S, g, &G::current_offset_A>>({0x2010, 1}, "measurement.current_offset_A",
                                               kind::current, when, -1, 0, 1,
                                               "read at zero current, subtracted"),
      real<Member<S, g, &G::voltage_offset_V>>({0x2010, 2}, "measurement.voltage_offset_V",
                                               kind::voltage, when, -1, 0, 1,
                                               "read at zero voltage, subtracted"),
      real<Member<S, g, &G::load_offset_N>>({0x2010, 3}, "measurement.load_offset_N", kind::force,
                                            when, -1e4F, 0, 1e4F, "read without load, subtracted"),
      real<Member<S, g, &G::load_gain>>({0x2010, 4}, "measurement.load_gain", kind::number, when,
                                        -100, 1, 100, "true load by reading"),
      real<Member<S, g, &G::current_noise_A>>({0x2010, 5}, "measurement.current_noise_A",
                                              kind::current, when, 0, 1e-5F, 1,
                                              "standard deviation of a reading"),
      real<Member<S, g, &G::voltage_noise_V>>({0x2010, 6}, "measurement.voltage_noise_V",
                                              kind::voltage, when, 0, 3e-4F, 1,
                                              "standard deviation of a reading"),
      real<Member<S, g, &G::lead_resistance_ohm>>({0x2010, 7}, "measurement.lead_resistance_ohm",
                                                  kind::resistance, when, 0, 0, 100,
                                                  "within the measured voltage; 0 with four wires"),
      real<Member<S, g, &G::constant_load_N>>({0x2010, 8}, "measurement.constant_load_N",
                                              kind::force, when, 0, 0, 1e4F,
                                              "taken where there is no load cell"),
      boolean<Member<S, g, &G::has_load_cell>>({0x2010, 9}, "measurement.has_load_cell", when, true,
                                               "the load is measured"),
      real<Member<S, g, &G::current_full_scale_A>>({0x2010, 10}, "measurement.current_full_scale_A",
                                                   kind::current, when, 1e-3F, 0.5F, 100,
                                                   "a reading at or beyond it is saturated"),
      real<Member<S, g, &G::voltage_full_scale_V>>({0x2010, 11}, "measurement.voltage_full_scale_V",
                                                   kind::voltage, when, 0.01F, 20, 1000,
                                                   "a reading at or beyond it is saturated"),
  });
}

template <class S>
constexpr auto observer_rows() {
  constexpr auto g = &Settings<S>::observer;
  using G = ObserverSettings<S>;
  constexpr auto when = Change::without_current;
  return std::to_array<Parameter<S>>({
      real<Member<S, g, &G::ambient_sd_K>>({0x2011, 1}, "observer.ambient_sd_K",
                                           kind::temperature_difference, when, 0.1F, 18, 100,
                                           "standard deviation of the first guess of the air's "
                                           "temperature"),
      real<Member<S, g, &G::loss_sd>>({0x2011, 2}, "observer.loss_sd", kind::number, when, 0.01F,
                                      0.3F, 2, "of the cooling, relative to the wire's file"),
  });
}

template <class S>
constexpr auto limit_rows() {
  constexpr auto g = &Settings<S>::limits;
  using G = SoftLimits<S>;
  constexpr auto live = Change::live;
  return std::to_array<Parameter<S>>({
      real<Member<S, g, &G::min_current_A>>({0x2020, 1}, "limits.min_current_A", kind::current,
                                            live, 1e-4F, 0.01F, 20,
                                            "while running: keeps the resistance measurable"),
      real<Member<S, g, &G::current_A>>({0x2020, 2}, "limits.current_A", kind::current, live, 1e-3F,
                                        0.1F, 20, "greatest current"),
      real<Member<S, g, &G::power_W>>({0x2020, 3}, "limits.power_W", kind::power, live, 1e-3F, 2,
                                      1000, "greatest power into the wire"),
      real<Member<S, g, &G::temperature_K>>({0x2020, 4}, "limits.temperature_K", kind::temperature,
                                            live, static_cast<float>(zero_degC_K), 393.15F, 600,
                                            "of the wire's hottest spot"),
      real<Member<S, g, &G::hot_spot_K>>({0x2020, 5}, "limits.hot_spot_K",
                                         kind::temperature_difference, live, 0, 18, 100,
                                         "how far the hottest spot may lie above the estimate"),
      real<Member<S, g, &G::min_strain>>({0x2020, 6}, "limits.min_strain", kind::number, live,
                                         -0.05F, 0, 0.2F, "of the shortest wire asked for"),
      real<Member<S, g, &G::max_strain>>({0x2020, 7}, "limits.max_strain", kind::number, live,
                                         -0.05F, 0.05F, 0.2F, "of the longest wire asked for"),
      real<Member<S, g, &G::stress_Pa>>({0x2020, 8}, "limits.stress_Pa", kind::stress, live, 1e6F,
                                        150e6F, 2e9F, "above it no more contraction is asked for"),
      real<Member<S, g, &G::duty>>({0x2020, 9}, "limits.duty", kind::number, live, 0.01F, 1, 1,
                                   "share of the squared current limit, averaged"),
      real<Member<S, g, &G::duty_window_s>>({0x2020, 10}, "limits.duty_window_s", kind::time, live,
                                            0.1F, 10, 3600, "over which it is averaged"),
      real<Member<S, g, &G::loss_margin>>({0x2020, 11}, "limits.loss_margin", kind::number, live, 1,
                                          1.15F, 100,
                                          "cooling believed at the temperature limit, by the "
                                          "wire's file"),
  });
}

template <class S>
constexpr auto trip_rows() {
  constexpr auto g = &Settings<S>::trips;
  using G = TripLimits<S>;
  constexpr auto when = Change::without_current;
  return std::to_array<Parameter<S>>({
      real<Member<S, g, &G::current_A>>({0x2021, 1}, "trips.current_A", kind::current, when, 1e-3F,
                                        0.15F, 25, "greatest current"),
      real<Member<S, g, &G::temperature_K>>({0x2021, 2}, "trips.temperature_K", kind::temperature,
                                            when, static_cast<float>(zero_degC_K), 403.15F, 650,
                                            "of the wire's hottest spot"),
      real<Member<S, g, &G::stress_Pa>>({0x2021, 3}, "trips.stress_Pa", kind::stress, when, 1e6F,
                                        200e6F, 3e9F, "greatest stress"),
      real<Member<S, g, &G::slack_Pa>>({0x2021, 4}, "trips.slack_Pa", kind::stress, when, -1e8F,
                                       1e6F, 2e9F, "below it the load is lost"),
      real<Member<S, g, &G::min_strain>>({0x2021, 5}, "trips.min_strain", kind::number, when, -0.1F,
                                         -0.005F, 0.25F, "of the shortest wire"),
      real<Member<S, g, &G::max_strain>>({0x2021, 6}, "trips.max_strain", kind::number, when, -0.1F,
                                         0.06F, 0.25F, "of the longest wire"),
      real<Member<S, g, &G::following_error>>({0x2021, 7}, "trips.following_error", kind::number,
                                              when, 1e-4F, 0.01F, 0.2F,
                                              "strain from set-point, for following_s"),
      real<Member<S, g, &G::following_s>>({0x2021, 8}, "trips.following_s", kind::time, when, 0.01F,
                                          2, 600, "how long it may last"),
      real<Member<S, g, &G::heating_rate_K_s>>({0x2021, 9}, "trips.heating_rate_K_s",
                                               kind::heating_rate, when, 1, 1e4F, 1e6F,
                                               "that the wire may have"),
      real<Member<S, g, &G::resistance_low>>({0x2021, 10}, "trips.resistance_low", kind::number,
                                             when, 0.05F, 0.8F, 0.99F,
                                             "of the cold wire, as a share of what its file says"),
      real<Member<S, g, &G::resistance_high>>({0x2021, 11}, "trips.resistance_high", kind::number,
                                              when, 1.01F, 1.2F, 20, "likewise"),
      real<Member<S, g, &G::current_offset_A>>({0x2021, 12}, "trips.current_offset_A",
                                               kind::current, when, 1e-6F, 0.002F, 1,
                                               "greatest zero-current reading at arming"),
      real<Member<S, g, &G::min_ambient_K>>({0x2021, 13}, "trips.min_ambient_K", kind::temperature,
                                            when, 173.15F, 253.15F, 400, "coldest air"),
      real<Member<S, g, &G::max_ambient_K>>({0x2021, 14}, "trips.max_ambient_K", kind::temperature,
                                            when, 173.15F, 333.15F, 400, "warmest air"),
      real<Member<S, g, &G::driver_K>>({0x2021, 15}, "trips.driver_K", kind::temperature, when,
                                       static_cast<float>(zero_degC_K), 358.15F, 450,
                                       "of the output stage"),
      real<Member<S, g, &G::drift>>({0x2021, 16}, "trips.drift", kind::number, when, 1e-3F, 0.05F,
                                    1, "of the resistance, relative: fatigue"),
      number<Member<S, g, &G::cycles>>({0x2021, 17}, "trips.cycles", when, 1, 100000, 0xFFFFFFFF,
                                       "full cycles before a warning"),
  });
}

template <class S>
constexpr auto safe_rows() {
  constexpr auto g = &Settings<S>::safe;
  using G = SafeSettings<S>;
  constexpr auto when = Change::without_current;
  return std::to_array<Parameter<S>>({
      choice<Member<S, g, &G::state>>({0x2022, 1}, "safe.state", safe_names, when, SafeState::off,
                                      "after a fault that leaves the choice"),
      real<Member<S, g, &G::hold_s>>({0x2022, 2}, "safe.hold_s", kind::time, when, 0, 0, 3600,
                                     "how long the strain is held, then off"),
      real<Member<S, g, &G::release_1_s>>({0x2022, 3}, "safe.release_1_s", kind::rate, when, 1e-5F,
                                          0.01F, 10, "strain rate of a release, then off"),
  });
}

template <class S>
constexpr auto axis_rows() {
  return std::to_array<Parameter<S>>({
      real<Member<S, &Settings<S>::axis, &PositionSettings<S>::zero_strain>>(
          {0x2030, 1}, "axis.zero_strain", kind::number, Change::without_current, -0.05F, 0.04F,
          0.2F, "at position 0; positions count contraction"),
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
                                           standard.proportional, 1e6F, "heating power by error"),
      real<Member<S, g, &G::integral_1_s>>({x, 2}, {p, ".integral_1_s"}, kind::rate, live, 0,
                                           standard.integral_1_s, 1000,
                                           "of the proportional gain: 1/T_i"),
      real<Member<S, g, &G::derivative_s>>({x, 3}, {p, ".derivative_s"}, kind::time, live, 0, 0, 10,
                                           "of the proportional gain: T_d"),
      real<Member<S, g, &G::derivative_filter_s>>({x, 4}, {p, ".derivative_filter_s"}, kind::time,
                                                  live, 0, 0.005F, 10, "on the measured variable"),
      real<Member<S, g, &G::setpoint_weight>>({x, 5}, {p, ".setpoint_weight"}, kind::number, live,
                                              0, 1, 1, "of the proportional part"),
      real<Member<S, g, &G::derivative_weight>>({x, 6}, {p, ".derivative_weight"}, kind::number,
                                                live, 0, 0, 1,
                                                "of the set-point in the derivative part"),
      real<Member<S, g, &G::tracking_s>>({x, 7}, {p, ".tracking_s"}, kind::time, live, 1e-4F, 0.05F,
                                         100, "anti-windup by back-calculation"),
      real<Member<S, g, &G::cooling_factor>>({x, 8}, {p, ".cooling_factor"}, kind::number, live,
                                             0.01F, 1, 100,
                                             "on the gains, where less heat is asked for"),
      real<Member<S, g, &G::dead_band>>({x, 9}, {p, ".dead_band", band_unit}, band, live, 0,
                                        standard.dead_band, 1000, "of the controlled variable"),
  });
}

template <class S>
constexpr auto drive_rows() {
  constexpr auto g = &Settings<S>::drive;
  using G = DriveSettings<S>;
  constexpr auto when = Change::without_current;
  return std::to_array<Parameter<S>>({
      choice<Member<S, g, &G::kind>>({0x2101, 1}, "drive.kind", drive_names, when,
                                     DriveKind::current, "what the output stage takes"),
      real<Member<S, g, &G::proportional>>({0x2101, 2}, "drive.proportional", kind::number,
                                           Change::live, 0, 0, 100,
                                           "of the current loop: volts by missing I R"),
      real<Member<S, g, &G::integral_1_s>>({0x2101, 3}, "drive.integral_1_s", kind::rate,
                                           Change::live, 0, 0, 1e5F, "of the current loop"),
      real<Member<S, g, &G::min_supply_V>>({0x2101, 4}, "drive.min_supply_V", kind::voltage, when,
                                           0, 5, 1000, "below it: fault"),
      real<Member<S, g, &G::max_supply_V>>({0x2101, 5}, "drive.max_supply_V", kind::voltage, when,
                                           0, 30, 1000, "above it: fault"),
  });
}

template <class S>
constexpr auto trajectory_rows() {
  constexpr auto g = &Settings<S>::trajectory;
  using G = TrajectorySettings<S>;
  return std::to_array<Parameter<S>>({
      real<Member<S, g, &G::heating_rate_1_s>>({0x2106, 1}, "trajectory.heating_rate_1_s",
                                               kind::rate, Change::live, 1e-5F, 0.6F, 100,
                                               "greatest strain rate asked for, contracting"),
      real<Member<S, g, &G::cooling_rate_1_s>>({0x2106, 2}, "trajectory.cooling_rate_1_s",
                                               kind::rate, Change::live, 1e-5F, 1, 100,
                                               "and stretching; never more than the wire can do"),
      real<Member<S, &Settings<S>::feed_forward_s>>(
          {0x2106, 3}, "trajectory.feed_forward_s", kind::time, Change::live, 0, 0.01F, 60,
          "in which the model's part brings the wire to its reference; 0: none"),
      real<Member<S, &Settings<S>::transfer_s>>(
          {0x2106, 4}, "trajectory.transfer_s", kind::time, Change::live, 0, 0.01F, 60,
          "time constant in which a new mode or gain takes over"),
      real<Member<S, g, &G::lead_s>>({0x2106, 5}, "trajectory.lead_s", kind::time, Change::live, 0,
                                     0.05F, 1, "by which a set-point that streams is led"),
  });
}

template <class S>
constexpr auto profile_rows() {
  constexpr auto g = &Settings<S>::profile;
  using G = ProfileSettings<S>;
  constexpr auto live = Change::live;
  return std::to_array<Parameter<S>>({
      real<Member<S, g, &G::overheat_K>>({0x2107, 1}, "profile.overheat_K",
                                         kind::temperature_difference, live, 0, 12, 100,
                                         "level 1 ends so far above the finish"),
      real<Member<S, g, &G::cycle_s>>({0x2107, 2}, "profile.cycle_s", kind::time, live, 0.05F, 5,
                                      3600, "of a full cycle"),
      real<Member<S, g, &G::loop_s>>({0x2107, 3}, "profile.loop_s", kind::time, live, 0.02F, 1.5F,
                                     3600, "of an inner loop"),
  });
}

}  // namespace smaservo
