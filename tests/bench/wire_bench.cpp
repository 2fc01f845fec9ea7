#include "tests/bench/time_step.hpp"
#include "tests/bench/wire_steps.hpp"

namespace smaservo::benchmarks {

void time_wire_steps() {
  for_each_wire_step(timing("double"));
}

}  // namespace smaservo::benchmarks
