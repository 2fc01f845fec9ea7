// Arbitrary frames of one service, to a servo before a device without physics.

#include <cstdlib>

#include "fuzzed_service.hpp"
#include "tests/firmware/canopen/servo/frame_feeder.hpp"
#include "tests/fuzz/processor_limit.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const smaservo::fuzz::ProcessorLimit limit;
  using namespace smaservo::canopen;
  static const smaservo::Settings<double> settings = smaservo::reference_settings();
  ServoConfig config;
  config.ceilings = ceilings_at(settings);
  ServoRig rig(config, settings);
  FrameFeeder feeder(rig, fuzzed_service);
  if (!feeder.feed({data, size}) || !feeder.comes_back()) {
    std::abort();
  }
  return 0;
}
