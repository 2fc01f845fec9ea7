#include "host-sim/tune/tune.hpp"

#include "host-sim/tune/uncertainty.hpp"

namespace smaservo {

/// Of the uncertain wires that close the loop in time.
constexpr int expected_members = 12;

Tuned tune(const std::string& wire, const TuneTask& task) {
  Tuned t{wire, task, propose(task), {}, {}, {}, {}};
  const auto possible = [&](LoopName name) {
    return t.proposal.loops[static_cast<std::size_t>(name)].possible;
  };
  t.chosen = chosen_settings(t.proposal.settings, possible(LoopName::resistance),
                             possible(LoopName::force));
  t.relays = relay_checks(task, t.proposal);
  t.expected =
      expected_steps(task, t.proposal, uncertain_plants(task.plant, expected_members, task.seed));
  t.worst = worst_steps(t.expected);
  return t;
}

}  // namespace smaservo
