#pragma once
// host-sim tune: gains for a wire and a load, their margins, and the expected behaviour.

#include <functional>
#include <string>
#include <vector>

#include "host-sim/tune/chosen.hpp"
#include "host-sim/tune/expected.hpp"
#include "host-sim/tune/proposal.hpp"
#include "host-sim/tune/relay/relay.hpp"
#include "host-sim/units.hpp"

namespace smaservo::tune {

struct Tuned {
  std::string wire;  ///< name of the wire
  /// The wire's name for a settings file; empty: the wire was changed and has no name.
  std::string based_on;
  TuneTask task;
  Proposal proposal;
  std::vector<Chosen> chosen;
  std::vector<RelayCheck> relays;
  ExpectedSteps expected;
  std::vector<StepResponse> worst;  ///< worst values of the expected steps
  std::vector<std::string> warnings;
};

/// Makes the whole tuning. The dead band of the strain is the least useful one, or up to eight
/// times that: the smallest with which every expected step settles. Throws UserError as propose()
/// does.
/// `progress` is called with the share of the work that is done, 0 to 1.
Tuned tune(
    const std::string& wire, const std::string& based_on, const TuneTask& task,
    const std::function<void(double)>& progress = [](double) {});

std::string tuned_text(const Tuned& tuned);
std::string tuned_json(const Tuned& tuned);
std::string tuned_toml(const Tuned& tuned);
/// Writes one HTML file that opens without a network. Throws UserError.
void write_tune_report(const std::string& path, const Tuned& tuned, Units units);

}  // namespace smaservo::tune
