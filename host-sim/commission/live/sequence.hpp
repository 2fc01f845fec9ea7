#pragma once
// Which power the wire gets for how long: a rest, a first careful cycle, two staircases through the
// whole transformation.

#include <cstddef>
#include <string>
#include <vector>

#include "firmware/prepared.hpp"

namespace smaservo::commission {

/// How long each level of the sequence lasts.
struct LevelTimes {
  double rest_s = 2;   ///< before the first heat, where the cold resistance is measured
  double first_s = 5;  ///< the careful cycle: heated, ...
  double cool_s = 5;   ///< ... and at rest again
  double up_s = 3;     ///< each level of a staircase upwards: several thermal time constants
  double down_s = 2.5;

  LevelTimes times(double factor) const {
    return {factor * rest_s, factor * first_s, factor * cool_s, factor * up_s, factor * down_s};
  }
};

inline constexpr std::size_t levels_up = 7, levels_down = 6, staircases = 2;
/// Number of points at which a person can be asked while the wire is heated. So many holds leave
/// the whole heating below 3 minutes.
inline constexpr std::size_t most_questions = 4;
/// The first cycle's share of the greatest current: nothing is known yet of this wire.
inline constexpr double first_share = 0.7;

enum class LevelKind : std::uint8_t { rest, first, cool, up, down };

struct Level {
  LevelKind kind;
  unsigned cycle;  ///< 0: before all cycles; 1: the careful one; 2 and 3: the staircases
  double power_W;
  double seconds;
  bool asks = false;  ///< a person is asked at its end
};

/// What the sequence is computed from.
struct SequenceInputs {
  double stress_Pa;
  double ambient_K;
  double cold_ohm;  ///< measured
};

struct Sequence {
  std::vector<Level> levels;
  double top_W;  ///< power of the hottest level
  double top_K;  ///< steady temperature there, by the wire of the settings in still air
  /// Whether the careful cycle alone transforms the wire of the settings.
  bool first_transforms;
  bool whole;  ///< whether the hottest level transforms that wire wholly

  double seconds() const;
};

/// Temperatures between which the wire of the settings transforms under this stress.
struct Span {
  double heating_start_K, heating_finish_K;
  double cooling_start_K, cooling_finish_K;
};
Span span_of(const Prepared<double>& device, double stress_Pa);

/// Powers are those that hold the wire of the settings in still air at temperatures from below its
/// transformation to above it, below the limits of current, power and temperature. Throws UserError
/// if the limits do not let half of the wire transform.
Sequence plan_sequence(const Prepared<double>& device, const SequenceInputs& inputs,
                       const LevelTimes& times, std::size_t questions);

/// "cycle 2 of 3, level 5 of 13"
std::string level_text(const Sequence& sequence, std::size_t level);

}  // namespace smaservo::commission
