#include "tests/bench/count_steps.hpp"
#include "tests/bench/device_steps.hpp"

namespace smaservo::benchmarks {

void add_device_runs(Runs& runs) {
  for_each_device_step<float>(adding(runs, "float"));
  for_each_device_step<double>(adding(runs, "double"));
}

}  // namespace smaservo::benchmarks
