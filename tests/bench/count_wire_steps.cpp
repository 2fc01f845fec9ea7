#include "tests/bench/count_steps.hpp"
#include "tests/bench/wire_steps.hpp"

namespace smaservo::benchmarks {

void add_wire_runs(Runs& runs) {
  for_each_wire_step(adding(runs, "double"));
}

}  // namespace smaservo::benchmarks
