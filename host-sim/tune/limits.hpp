#pragma once
// The part of a proposal that does not follow from the loops' margins: sensors, limits, rates, dead
// bands.

#include "host-sim/tune/proposal.hpp"

namespace smaservo::tune {

/// Standard deviation of one reading.
double resistance_noise_ohm(const MeasurementSettings<double>& m, double ohm, double current_A);

/// Throws UserError where the wire hardly moves.
void require_motion(const TuneTask& task, const Branches& branches);

/// Everything of p.settings but gains and dead bands, from p.branches. Throws UserError where the
/// current does not suffice.
void choose_limits(const TuneTask& task, Proposal& p);

/// Three standard deviations of the measured resistance, at the current that holds the wire.
double resistance_dead_band_ohm(const Proposal& p);

/// Of the strain: three standard deviations of the estimate due to the sensors' noise, and at least
/// a tenth of wire.accuracy.strain.
double min_dead_band(const TuneTask& task, const Proposal& p);

}  // namespace smaservo::tune
