#pragma once
// One cycle of a wire that works: heated by a constant current until it has contracted, then cooled
// until it is stretched again.

#include <optional>
#include <vector>

#include "model/wire/wire.hpp"
#include "model/wire/wire_plant.hpp"

namespace smaservo::choose {

/// What pulls on one wire.
struct Pull {
  double load_N;     ///< the load's share, at least while the wire contracts
  bool load_stays;   ///< a weight: the load also stretches the wire
  double preload_N;  ///< of a bias spring, on the cold wire
  double rate_N_m;   ///< by which the spring pulls more for each metre of contraction

  double cold_N() const { return (load_stays ? load_N : 0) + preload_N; }
  double contracted_N(double contraction_m) const {
    return load_N + preload_N + rate_N_m * contraction_m;
  }
};

/// Where the cycle takes place, and how far the wire has to contract.
struct CycleTask {
  Wire<double> wire;
  Pull pull;
  double contraction_m;
  double ambient_K;
};

/// The course of a wire; all have one element for each step.
struct Course {
  std::vector<double> time_s, contraction_m, temperature_K;
};

/// What `overheats_s` looks for.
inline constexpr double longest_heating_s = 120;

/// A wire at the moment at which it has contracted.
struct Contracted {
  WirePlant<double> plant;  ///< now
  double rest_strain;       ///< at the beginning
  double current_A;
  double seconds;        ///< from the beginning until now
  double ohm;            ///< greatest resistance on the way
  double temperature_K;  ///< now, which is the hottest
  double hold_A;         ///< what holds this temperature in still air
  /// Time, from the beginning, after which the same current makes the wire hotter than its limit;
  /// none if that is later than longest_heating_s.
  std::optional<double> overheats_s;
  Course course;  ///< until now, which is not in it
};

/// By how much the wire becomes shorter at its limit of temperature, from rest at the ambient
/// temperature, pulled as cold and as contracted.
double greatest_contraction_m(const CycleTask& task);

/// The least current, within 0.1 %, that makes the wire contract as far as asked within `seconds`.
/// None if the wire would pass its limit of temperature before.
std::optional<Contracted> contract(const CycleTask& task, double seconds);

/// What stretch_again() waits for.
inline constexpr double longest_stretch_s = 300;

/// Time without current until a wire that has contracted is stretched again but for `left_m`; none
/// if that takes longer than longest_stretch_s. `draught` is the factor on the heat loss of still
/// air. `course`, if there is one, gets each step.
std::optional<double> stretch_again(const CycleTask& task, const Contracted& contracted,
                                    double draught, double left_m, Course* course = nullptr);

}  // namespace smaservo::choose
