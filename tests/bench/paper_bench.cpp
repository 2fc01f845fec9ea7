#include "tests/bench/paper_steps.hpp"
#include "tests/bench/time_step.hpp"

namespace smaservo::benchmarks {

void time_paper_steps() {
  for_each_paper_step<float>(timing("float"));
  for_each_paper_step<double>(timing("double"));
}

}  // namespace smaservo::benchmarks
