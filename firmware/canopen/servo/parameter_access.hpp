#pragma once
// The node's access to the parameters of a device, independent of its scalar type; and their upper
// bounds.

#include <limits>

#include "firmware/canopen/node/object.hpp"

namespace smaservo::canopen {

/// Upper bounds of parameters that no write over the bus can raise: they come from a file that only
/// the administrator can change, or from the board's design. Infinity: no ceiling.
struct Ceilings {
  static constexpr float none = std::numeric_limits<float>::infinity();
  float current_A = none;      ///< limits.current_A
  float power_W = none;        ///< limits.power_W
  float temperature_K = none;  ///< limits.temperature_K
  float stress_Pa = none;      ///< limits.stress_Pa
  float trip_current_A = none, trip_temperature_K = none, trip_stress_Pa = none;  ///< trips.*
};

/// The ceiling of a parameter; infinity if it has none.
constexpr float ceiling_of(const Ceilings& c, Key key) {
  switch (static_cast<std::uint32_t>(key.index) << 8U | key.sub) {
    case 0x202002:
      return c.current_A;
    case 0x202003:
      return c.power_W;
    case 0x202004:
      return c.temperature_K;
    case 0x202008:
      return c.stress_Pa;
    case 0x202101:
      return c.trip_current_A;
    case 0x202102:
      return c.trip_temperature_K;
    case 0x202103:
      return c.trip_stress_Pa;
    default:
      return Ceilings::none;
  }
}

/// The positions that correspond to limits.max_strain (low) and limits.min_strain (high).
struct Reach {
  float low_m, high_m;
};

enum class TuningState : std::uint8_t { none, open, on_trial };
enum class TuningCommand : std::uint8_t {
  none,
  begin,
  attempt,
  commit,
  revert,
  leave,  ///< as attempt, by a client that goes: until the trial's end nobody has to be there
};

/// Access to parameters by key. Handles are rows of the table.
class ParameterAccess {
 public:
  virtual Abort find(Key key, Entry& entry) const = 0;
  virtual std::uint32_t read(std::uint16_t row) const = 0;
  virtual Level level(std::uint16_t row) const = 0;
  /// The value takes effect at once, or within a transaction together with the others.
  virtual Abort write(std::uint16_t row, std::uint32_t value, bool enabled) = 0;
  virtual Abort tune(TuningCommand command, float trial_s, bool enabled) = 0;
  /// To be called once per step; returns whether a trial has just ended.
  virtual bool tick(float dt_s) = 0;

  /// Whether a change can be taken now.
  virtual bool has_room() const = 0;
  virtual TuningState state() const = 0;
  virtual float remaining_s() const = 0;
  /// The parameter whose last write was refused, and the one that it contradicts; key 0: none.
  virtual Key refused() const = 0;
  virtual Key refused_other() const = 0;
  virtual bool has_load_cell() const = 0;
  virtual Reach reach() const = 0;

 protected:
  ~ParameterAccess() = default;
};

}  // namespace smaservo::canopen
