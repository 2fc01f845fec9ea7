// Fills in what the steps of files give on this machine, summed in the order of a processor without
// vector registers:
//   answer_steps FILE...

#include <bit>
#include <cmath>
#include <cstdio>
#include <limits>

#include "tests/mcu/whole_step_file.hpp"

namespace smaservo::mcu {
namespace {

Ranges ranges(const std::vector<StepRecord>& records) {
  Ranges all{};
  for (std::size_t i = 0; i < all.size(); ++i) {
    float min = std::numeric_limits<float>::infinity(), max = -min;
    for (const StepRecord& record : records) {
      const float number = std::bit_cast<StepNumbers>(record.outputs).number[i];
      min = std::isfinite(number) ? std::fmin(min, number) : min;
      max = std::isfinite(number) ? std::fmax(max, number) : max;
    }
    // Of what stands still, its size.
    all[i] = min < max ? max - min : std::fmax(std::abs(max), 1e-30F);
  }
  return all;
}

bool answer(WholeStepFile& file) {
  const auto settings = file.settings<float>();
  if (!settings) {
    return false;
  }
  const Prepared<float> prepared = prepare(*settings);
  Device<float>::State state = Device<float>::start();
  for (StepRecord& record : file.records) {
    record.outputs = step(prepared, state, record.inputs);
  }
  file.header.ranges = ranges(file.records);
  return true;
}

}  // namespace
}  // namespace smaservo::mcu

int main(int argc, char** argv) {
  for (int i = 1; i < argc; ++i) {
    smaservo::mcu::WholeStepFile file(argv[i]);
    if (!smaservo::mcu::answer(file) || !file.save()) {
      std::fprintf(stderr, "%s: is no step file, or cannot be written\n", argv[i]);
      return 1;
    }
  }
  return argc > 1 ? 0 : 2;
}
