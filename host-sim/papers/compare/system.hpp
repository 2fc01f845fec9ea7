#pragma once
// Systems that tell a wire's strain without a sensor of the strain. Each is identified on training
// runs and tested on others.

#include <functional>
#include <string>
#include <vector>

#include "host-sim/identify/runs/run.hpp"
#include "model/wire/wire.hpp"

namespace smaservo::compare {

/// One identified system.
struct System {
  std::string name;
  std::string meaning;
  int parameters = 0;  ///< number of parameters that were identified
  std::string remark;  ///< which data it could not use, or why it was not identified
  /// Strain of every row of a run; NaN without an estimate. Empty when the runs could not identify
  /// the system.
  std::function<std::vector<double>(const identify::Run&)> strain;
};

/// From the resistance alone: one line; a polynomial of fourth order; two lines, one for heating
/// and one for cooling. Least squares over all rows that have both, all runs counting alike. Each
/// throws UserError where no run has strain and resistance.
System one_line(const std::vector<identify::Run>& runs);
System polynomial(const std::vector<identify::Run>& runs);
/// The direction is that of the last change of the resistance by more than 1 %.
System two_lines(const std::vector<identify::Run>& runs);

/// 002. Throws UserError where no run has a resistance, and as identify_strain_resistance() says.
System stress_strain_resistance(const std::vector<identify::Run>& runs);

/// Kinetics and heat balance from power and stress, or in a bath from its temperature, without
/// feedback. `from` gives geometry, limits and priors. Only the strain is fitted.
System duhem(const Wire<double>& from, const std::vector<identify::Run>& runs, int threads);
System liang_rogers(const Wire<double>& from, const std::vector<identify::Run>& runs, int threads);

/// The result of identify.
struct IdentifiedWire {
  Wire<double> wire;
  int parameters;
  std::vector<double> ambient_K;  ///< of every training run, as the fit has it
  /// For runs without an ambient temperature: the mean of the training runs.
  double room_K;
};

/// 003. Temperatures are those of the identified heat balance.
System preisach(const IdentifiedWire& identified, const std::vector<identify::Run>& runs);

/// The project's model by itself, and its observer.
System ihyp_alone(const IdentifiedWire& identified);
System ihyp_observer(const IdentifiedWire& identified);

}  // namespace smaservo::compare
