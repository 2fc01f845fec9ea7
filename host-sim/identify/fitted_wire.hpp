#pragma once
// The result of a fit as a wire description, with a source for each number.

#include <string>
#include <string_view>

#include "host-sim/identify/fit/fit.hpp"
#include "model/files/wire/wire_file.hpp"

namespace smaservo::identify {

/// The last part of a path.
std::string file_name(const std::string& path);

/// A parameter in the unit that messages use; both standard deviations are of the value in this
/// unit.
struct Figure {
  double value, sd;
  double prior, prior_sd;
};
Figure figure(const FittedParameter& fitted);

/// "74.80 ± 0.12", with as many digits as the standard deviation justifies.
std::string with_deviation(double value, double sd);

/// "temperature from 68 to 66.20 ± 0.12 degC".
std::string moved_text(const FittedParameter& fitted, std::string_view name);

/// "wire.m2a" of "wire.m2a.width"; "wire.heat" of "wire.heat.convection".
std::string group_of(std::string_view key);

/// The fitted wire with sources by group: the runs, what they determine and how well, and what is
/// left unchanged. Values that a fit does not change keep the sources of `from`. Throws UserError,
/// which names the worst run, if the fit explains less than half of the runs (strain within 15 % of
/// the nominal stroke (RMS), without strain the resistance within 10 %, in calorimetry the heat
/// flow within 50 % of its greatest value); if it is farther from a run than the run's own mean;
/// and if a wire file could not hold the wire.
files::WireDescription fitted_wire(const files::WireDescription& from, const FitResult& fit,
                                   const std::string& name);

}  // namespace smaservo::identify
