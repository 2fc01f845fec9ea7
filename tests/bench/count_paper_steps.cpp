#include "tests/bench/count_steps.hpp"
#include "tests/bench/paper_steps.hpp"

namespace smaservo::benchmarks {

void add_paper_runs(Runs& runs) {
  for_each_paper_step<float>(adding(runs, "float"));
  for_each_paper_step<double>(adding(runs, "double"));
}

}  // namespace smaservo::benchmarks
