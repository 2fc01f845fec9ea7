#pragma once
// Measured runs of a wire, to which its parameters are fitted. A run is a whole trace in SI,
// checked for errors that would make a fit wrong unnoticed.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "hal/replay/trace.hpp"
#include "model/wire/wire.hpp"

namespace smaservo::identify {

/// The kind of an experiment. It follows from the columns; the first matching kind counts:
/// - calorimetry: `power` and temperature; a sample heated and cooled in a calorimeter.
/// - joule: current and voltage that heat the wire, and time. There may be a temperature, but that
///   of an infrared camera or a thermocouple on a thin wire is unreliable and is not needed.
/// - settled: current and voltage that heat the wire, without time: each row is a settled state.
/// - bath: temperature, in a liquid or an oven. There may be current and voltage if they only
///   measure the resistance, with less than 0.1 W per metre: 2 K in still air, less in a bath.
/// All but calorimetry need a stress; joule and settled a strain, bath a strain or a resistance.
enum class RunKind : unsigned char { bath, joule, settled, calorimetry };

std::string_view name_of(RunKind kind);

/// Vectors have one element for each row, or none if the run lacks the quantity.
struct Run {
  std::string name;  ///< name of the file
  RunKind kind;
  std::vector<double> time_s, current_A, voltage_V;
  /// From the column of the stress, otherwise from load per area, otherwise from the options; in
  /// calorimetry otherwise 0.
  std::vector<double> stress_Pa;
  /// The column strain_ref. Otherwise -displacement/length, with its zero at the greatest length of
  /// the wire: such a strain is 0 or negative and does not give the absolute elongation.
  std::vector<double> strain;
  /// The column, otherwise V/I; NaN in rows where the current is below 3 % of the run's largest.
  std::vector<double> resistance_ohm;
  std::vector<double> temperature_K, ambient_K;
  std::vector<double> power_W_kg;
};

struct RunOptions {
  Geometry<double> geometry;
  std::optional<double> stress_Pa;  ///< for files that have neither stress nor load
  std::optional<double> load_N;     ///< like stress_Pa; used if there is no stress_Pa
  hal::TraceOptions trace;
};

/// Reads the whole file. Throws UserError, which says what to measure instead, for a file that
/// - is of no kind, has fewer than 20 rows, or nothing to fit to;
/// - shows no motion: strain within 0.3 % and resistance within 2 %, or in calorimetry temperature
///   within 10 K, each without the outermost hundredths;
/// - has a clipped column, as far as that is certain (run_checks.cpp says when);
/// - has a quantity with the wrong sign: voltage against current, a pushing load, a wire that gets
///   longer when it is heated, a heat flow with exothermic up;
/// - contradicts itself: strain over more than 0.2, stress above 1.5 GPa, resistance more than a
///   factor of 5 beyond that of 0.5-1.5 µΩm, power that heats the wire by more than 1e5 K/s,
///   temperatures that are degC in a column of K or the other way round.
/// Throws TraceError for errors that no trace may have.
Run read_run(const std::string& path, const RunOptions& options);

/// Whether a run's strains are absolute elongations. They are not if the smallest or greatest value
/// of the column is exactly 0, since such a column was zeroed there.
bool zero_known(const std::vector<double>& strain);

}  // namespace smaservo::identify
