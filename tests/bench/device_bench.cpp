#include "tests/bench/device_steps.hpp"
#include "tests/bench/time_step.hpp"

namespace smaservo::benchmarks {

void time_device_steps() {
  for_each_device_step<float>(timing("float"));
  for_each_device_step<double>(timing("double"));
}

}  // namespace smaservo::benchmarks
