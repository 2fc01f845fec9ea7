#pragma once
// A second wire to begin from: the type's, with transformations that are broad and have long ends.

#include "model/wire/wire.hpp"

namespace smaservo::commission {

/// The wire `from` with broad transformations. The presets' transformations are as narrow, and
/// begin and end as suddenly, as paper 000's. Of measured wires some are so (the Flexinol of
/// host-sim/identify/README.md), others transform over twice as many kelvin with slow beginnings
/// and ends (the NiTiCo there, on cooling), and R-phase becomes austenite some kelvin below
/// martensite. The numbers are the means of what `identify` found from simulated wires of that
/// kind, as deviations from the type: host-sim/commission/README.md, 'The two beginnings'. The cold
/// resistance stays that of `from`.
Wire<double> broad_wire(const Wire<double>& from);

}  // namespace smaservo::commission
