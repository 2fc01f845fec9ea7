#pragma once
// Gains, limits and rates for a wire under a load, from its linearisation; every loop keeps its
// margins in every state of every wire that the file may represent.

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

/// A state of one of the wires, and the device's assumptions on it.
struct Situation {
  std::size_t member;
  OperatingPoint point;
  double law_J;         ///< heat law by strain, at the worst place within the accuracy
  double believed_W_K;  ///< slope of the loss that the device assumes
};

/// One loop with its margins.
struct DesignedLoop {
  LoopName name;
  bool possible;  ///< false: in no state of the wire this variable responds to heat
  /// Share of the states in which the variable responds; the wire only passes through the others.
  double answering;
  Margins nominal, worst;
  Situation worst_at;  ///< situation with the least phase margin
  /// States that respond: of the file's wire, and of all wires.
  std::vector<LinearLoop> nominal_loops, loops;
};

struct Proposal {
  /// Settings of a whole device; chosen_settings() gives the chosen ones.
  Settings<double> settings;
  Branches branches;  ///< branches of the file's wire
  std::vector<Situation> situations;
  std::vector<DesignedLoop> loops;
  double holding_A;  ///< current that keeps the wire short in the greatest draught
  double supply_V;   ///< voltage that the current limit needs
};

struct TuneTask {
  TunedPlant plant;      ///< the wire of the file
  double max_current_A;  ///< infinite: no bound but the current for the stroke in 0.1 s
  int members = 24;
  std::uint64_t seed = 1;
};

/// Proposes settings, with the smallest useful dead band of the strain. Throws UserError if the
/// wire does not move at this load and ambient temperature, or if the current is not sufficient to
/// hold it.
Proposal propose(const TuneTask& task);

/// The device's settings for this wire without any gains; `current_A` is the limit.
Settings<double> bare_settings(const Wire<double>& wire, double current_A);

}  // namespace smaservo::tune
