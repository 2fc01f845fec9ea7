#pragma once
// Which wires of the makers' tables move a load, and what they then need. README.md has the rules.

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "host-sim/choose/cycle.hpp"
#include "host-sim/choose/makers.hpp"

namespace smaservo::choose {

/// A bias spring: it pulls with `preload_N` on the cold wire, and by `rate_N_m` more for each metre
/// of contraction.
struct Spring {
  double preload_N, rate_N_m;
};

/// Most wires side by side.
inline constexpr int most_parallel = 32;

/// What wires have to do.
struct Task {
  double force_N;                  ///< against which they contract, 0 to 1000
  double stroke_m;                 ///< 1e-6 to 1
  double time_s;                   ///< in which they contract, 0.01 to 60
  std::optional<double> length_m;  ///< of each; none: as short as the stroke allows
  /// A person's own spring; none: one is proposed where the load does not stretch the wire.
  std::optional<Spring> spring;
  /// The force acts only while the wire contracts, as friction does. Otherwise it is a weight.
  bool one_way = false;
  std::optional<double> supply_V;
  double ambient_K;    ///< 233 to 373
  double fan_m_s = 2;  ///< speed of the air that a fan moves across the wire, 0 to 50
  Life life = Life::many;
  /// At most so many wires side by side. The current flows through one after the other.
  int parallel = 1;
};

/// A wire that does it.
struct Suitable {
  std::string wire;  ///< its preset
  int parallel;      ///< number of wires side by side
  double length_m;
  double strain;                     ///< stroke over length
  double stress_Pa, cold_stress_Pa;  ///< contracted, and cold
  double current_A;                  ///< through each wire, while it contracts
  double voltage_V, power_W;         ///< the greatest meanwhile, of all wires together
  double hold_A;                     ///< what holds them contracted, in still air
  double hottest_K;
  std::optional<double> overheats_s;               ///< as Contracted has it
  std::optional<double> back_still_s, back_fan_s;  ///< time until 95 % of the stroke is back
  std::optional<Spring> spring;  ///< that is proposed, or given; of all wires together
  std::string_view cycles;       ///< what the maker says of their number
  /// The makers' figures for this wire, as MakersWire has them.
  std::optional<double> makers_current_A, makers_cooling_s;
  double seconds;              ///< until it has contracted
  Course heating, still, fan;  ///< `still` and `fan` begin when it has contracted
};

struct Unsuitable {
  std::string wire;  ///< as name_of() has it, of the number that comes furthest
  std::string why;
};

struct Choice {
  std::vector<Suitable> suitable;  ///< by their power, the least first
  std::vector<Unsuitable> others;  ///< in the order of makers_wires()
};

/// "2 x flexinol-lt-0.20mm".
std::string name_of(int parallel, const std::string& wire);

/// Takes a tenth of a second; some seconds for a `time_s` of a minute. Throws UserError for a
/// number out of its range, and when `ended`, which is asked for each wire, says so.
Choice choose_wires(const Task& task, const std::function<bool()>& ended = [] { return false; });

/// A maker's figures beside the plant's for the same: 100 mm contract by 90 % of what they can in a
/// second, against the suggested load, in still air of 25 °C; then they are stretched by the
/// maker's load for that, but for 0.5 % of their length.
struct MakersCheck {
  std::string wire;
  double makers_current_A, current_A, makers_cooling_s, cooling_s;
};
std::vector<MakersCheck> check_makers();

}  // namespace smaservo::choose
