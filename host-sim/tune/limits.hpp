#pragma once
// The part of a proposal that does not follow from the margins of the loops: sensors, limits,
// rates, dead bands.

#include "host-sim/tune/proposal.hpp"

namespace smaservo::tune {

/// Standard deviation of one reading of the resistance.
double resistance_noise_ohm(const MeasurementSettings<double>& m, double ohm, double current_A);

/// Throws UserError if the wire hardly moves.
void require_motion(const TuneTask& task, const Branches& branches);

/// Chooses everything in p.settings except gains and dead bands, from p.branches. Throws UserError
/// if the current is not sufficient.
void choose_limits(const TuneTask& task, Proposal& p);

/// Three standard deviations of the measured resistance at the current that holds the wire.
double resistance_dead_band_ohm(const Proposal& p);

/// Least dead band of the strain: three standard deviations of the estimate due to the sensors'
/// noise, but at least a tenth of wire.accuracy.strain.
double min_dead_band(const TuneTask& task, const Proposal& p);

}  // namespace smaservo::tune
