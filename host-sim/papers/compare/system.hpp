#pragma once
// Systems that estimate a wire's strain without a strain sensor. Each is identified on training
// runs and tested on others.

#include <functional>
#include <string>
#include <vector>

#include "host-sim/identify/runs/run.hpp"
#include "host-sim/papers/gru/network.hpp"
#include "model/wire/wire.hpp"

namespace smaservo::compare {

/// One identified system.
struct System {
  std::string name;
  std::string meaning;
  int parameters = 0;  ///< number of parameters that were identified
  std::string remark;  ///< data that it could not use, or the reason why it was not identified
  /// The strain in every row of a run; NaN without an estimate. Empty if the runs could not
  /// identify the system.
  std::function<std::vector<double>(const identify::Run&)> strain;
};

/// Strain from the resistance alone: one line; a polynomial of fourth order; two lines, one for
/// heating and one for cooling. Least squares over all rows that have both quantities, with equal
/// weights for all runs. Each throws UserError if no run has strain and resistance.
System one_line(const std::vector<identify::Run>& runs);
System polynomial(const std::vector<identify::Run>& runs);
/// The direction is that of the last change of the resistance by more than 1 %.
System two_lines(const std::vector<identify::Run>& runs);

/// The estimator of paper 002. Throws UserError if no run has a resistance, and like
/// identify_strain_resistance().
System stress_strain_resistance(const std::vector<identify::Run>& runs);

/// Kinetics and heat balance from power and stress (in a bath from its temperature), without
/// feedback. `from` gives geometry, limits and priors. Only the strain is fitted.
System duhem(const Wire<double>& from, const std::vector<identify::Run>& runs, int threads);
System liang_rogers(const Wire<double>& from, const std::vector<identify::Run>& runs, int threads);

/// The wire that `identify` has found.
struct IdentifiedWire {
  Wire<double> wire;
  int parameters;
  std::vector<double> ambient_K;  ///< ambient temperature of every training run in the fit
  /// The mean of the training runs, for runs without an ambient temperature.
  double usual_ambient_K;
};

/// The model of paper 003. Temperatures are those of the identified heat balance.
System preisach(const IdentifiedWire& identified, const std::vector<identify::Run>& runs);

/// The project's model alone, and its observer.
System ihyp_alone(const IdentifiedWire& identified);
System ihyp_observer(const IdentifiedWire& identified);

/// A network that was trained elsewhere, at its own steps, from resistance, power and stress; none
/// in a bath. A row without a resistance holds the last strain. The remark says which of the tests
/// it was trained on, and if it was not trained on the training runs alone.
System recurrent_network(const gru::Network& network, const std::vector<identify::Run>& training,
                         const std::vector<identify::Run>& tests);

}  // namespace smaservo::compare
