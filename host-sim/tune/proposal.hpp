#pragma once
// Gains, limits and rates for a wire under a load, from its linearisation; every loop keeps its
// margins in every state of every wire that the file may stand for.

#include <array>
#include <string>
#include <vector>

#include "firmware/settings.hpp"
#include "host-sim/tune/linear/loop.hpp"
#include "host-sim/tune/linear/operating_points.hpp"

namespace smaservo::tune {

enum class LoopName : unsigned char { strain, temperature, resistance, force };
inline constexpr std::array loop_names{LoopName::strain, LoopName::temperature,
                                       LoopName::resistance, LoopName::force};
const char* loop_text(LoopName name);

/// A state of one of the wires, and what the device believes of it.
struct Situation {
  std::size_t member;
  OperatingPoint point;
  double law_J;         ///< of the heat law by strain, at the worst place within the accuracy
  double believed_W_K;  ///< slope of the loss
};

/// One loop with its margins.
struct DesignedLoop {
  LoopName name;
  bool possible;     ///< false: no state of the wire answers to heat by this variable
  double answering;  ///< share of the states that do; the wire only passes through the others
  Margins nominal, worst;
  Situation worst_at;                            ///< where the phase margin is least
  std::vector<LinearLoop> nominal_loops, loops;  ///< of the states that answer; all wires
};

struct Proposal {
  Settings<double> settings;  ///< a whole device's; chosen_settings() says which of it was chosen
  Branches branches;          ///< of the wire itself
  std::vector<Situation> situations;
  std::vector<DesignedLoop> loops;
  double holding_A;  ///< keeps the wire short in the greatest draught
  double supply_V;   ///< that the current limit needs
};

struct TuneTask {
  TunedPlant plant;      ///< the wire of the file
  double max_current_A;  ///< infinite: whatever the stroke in 0.1 s needs
  int members = 24;
  std::uint64_t seed = 1;
};

/// Proposes settings, with the smallest useful dead band of the strain. Throws UserError when the
/// wire does not move at this load and ambient temperature, or when the current does not suffice to
/// hold it.
Proposal propose(const TuneTask& task);

/// The device's settings for this wire with none of its gains; `current_A` is its limit.
Settings<double> bare_settings(const Wire<double>& wire, double current_A);

}  // namespace smaservo::tune
