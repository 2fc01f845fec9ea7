#include "host-sim/tune/chosen.hpp"

#include <fmt/format.h>

namespace smaservo::tune {
namespace {

void add_loop(std::vector<Chosen>& all, const char* table, const char* gain, const char* band,
              const LoopGains<double>& q, const char* why, const char* why_band) {
  all.push_back({table, gain, q.proportional, why});
  all.push_back({table, "integral_1_s", q.integral_1_s, "the fastest that leaves 60° of phase"});
  all.push_back({table, "derivative_s", q.derivative_s, "none: the wire is of first order"});
  all.push_back({table, "tracking_s", q.tracking_s, "half of the integral time"});
  all.push_back({table, band, q.dead_band, why_band});
}

}  // namespace

std::vector<Chosen> chosen_settings(const Settings<double>& s, bool resistance, bool force) {
  const char* tenth = "closes an error in ten periods where the wire is fastest";
  const char* none = "none";
  std::vector<Chosen> all{
      {"measurement", "current_noise_A", s.measurement.current_noise_A, "assumed; put in your own"},
      {"measurement", "voltage_noise_V", s.measurement.voltage_noise_V, "assumed; put in your own"},
      {"measurement", "current_full_scale_A", s.measurement.current_full_scale_A,
       "the least that suffices"},
      {"measurement", "voltage_full_scale_V", s.measurement.voltage_full_scale_V,
       "the least that suffices"},
      {"measurement", "constant_load_N", s.measurement.constant_load_N,
       "the load of the cold wire"},
      {"limits", "min_current_A", s.limits.min_current_A, "resistance noise 0.1 %, or 2 K of heat"},
      {"limits", "current_A", s.limits.current_A,
       "makes the stroke in 0.1 s or a fifth of the stretching time"},
      {"limits", "power_W", s.limits.power_W, "that current in the greatest resistance"},
      {"limits", "temperature_K", s.limits.temperature_K,
       "reaches and holds the stroke in a draught, hot spot included"},
      {"limits", "hot_spot_K", s.limits.hot_spot_K,
       "how far the hottest point may lie above the estimate"},
      {"limits", "min_strain", s.limits.min_strain, "end of the stroke"},
      {"limits", "max_strain", s.limits.max_strain, "strain of the cold wire"},
      {"limits", "stress_Pa", s.limits.stress_Pa, "a quarter above the load, or the maker's limit"},
      {"limits", "duty", s.limits.duty, "the maker's current, or what holds it in a draught"},
      {"limits", "duty_window_s", s.limits.duty_window_s, "over which the current is averaged"},
      {"trips", "current_A", s.trips.current_A, "beyond the limit"},
      {"trips", "temperature_K", s.trips.temperature_K, "beyond the limit"},
      {"trips", "stress_Pa", s.trips.stress_Pa, "beyond the limit"},
      {"trips", "slack_Pa", s.trips.slack_Pa, "well below the load"},
      {"trips", "current_offset_A", s.trips.current_offset_A, "well below the least current"},
      {"trips", "min_strain", s.trips.min_strain, "beyond the limit"},
      {"trips", "max_strain", s.trips.max_strain, "beyond the limit"},
      {"trips", "following_s", s.trips.following_s,
       "three times the time that the wire takes to stretch"},
      {"axis", "zero_strain", s.axis.zero_strain, "strain of the cold wire"},
      {"strain", "proportional_W", s.strain.proportional, "none: the heat law is the gain"},
      {"strain", "integral_1_s", s.strain.integral_1_s, "none: the observer finds the loss"},
      {"strain", "dead_band", s.strain.dead_band, "the least with which all wires hold"},
      {"trajectory", "heating_rate_1_s", s.trajectory.heating_rate_1_s,
       "a faster one would also warm the cold ends"},
      {"trajectory", "cooling_rate_1_s", s.trajectory.cooling_rate_1_s,
       "the wire's fastest, in a draught"},
      {"trajectory", "feed_forward_s", s.feed_forward_s,
       "time in which the heat law closes an error"}};
  add_loop(all, "temperature", "proportional_W_K", "dead_band_K", s.temperature, tenth, none);
  if (resistance) {
    add_loop(all, "resistance", "proportional_W_ohm", "dead_band_ohm", s.resistance, tenth,
             "three deviations of its noise");
  }
  if (force) {
    add_loop(all, "force", "proportional_W_N", "dead_band_N", s.force,
             "twice the 23 ms of the load's filter", none);
  }
  return all;
}

std::string chosen_toml(const std::vector<Chosen>& chosen, const std::string& heading) {
  std::string text = heading;
  std::string table;
  for (const Chosen& c : chosen) {
    if (table != c.table) {
      table = c.table;
      text += fmt::format("\n[{}]\n", table);
    }
    const std::string line = fmt::format("{} = {:.6g}", c.key, c.value);
    // The decimal point keeps TOML from reading a whole number as an integer.
    const bool whole = line.find_first_of(".e", line.find('=')) == std::string::npos;
    text += fmt::format("{:<36}# {}\n", line + (whole ? ".0" : ""), c.why);
  }
  return text;
}

}  // namespace smaservo::tune
