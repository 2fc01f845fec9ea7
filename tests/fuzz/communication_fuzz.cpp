// The image of the communication objects, as a store may give it back: arbitrary bytes; or, behind
// a first byte that is odd, with its checksum made right.

#include <cstdlib>

#include "firmware/canopen/node/object.hpp"
#include "tests/firmware/canopen/servo/frame_feeder.hpp"
#include "tests/fuzz/processor_limit.hpp"

namespace {

using namespace smaservo::canopen;

void demand(bool holds) {
  if (!holds) {
    std::abort();
  }
}

/// What the node would store now.
Bytes image_of(const ServoRig& rig) {
  Bytes image(Node::image_size);
  image.resize(rig.servo.node().image(image));
  return image;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const smaservo::fuzz::ProcessorLimit limit;
  static const smaservo::Settings<double> settings = smaservo::reference_settings();
  ServoConfig config;
  config.ceilings = ceilings_at(settings);
  ServoRig rig(config, settings);
  rig.image.assign(data + std::min<std::size_t>(size, 1), data + size);
  if (size > 2 && data[0] % 2 == 1) {
    const std::span image(rig.image);
    put_number(image.last(2), crc16(image.first(image.size() - 2)));
  }
  const bool good = rig.servo.start(rig.image, rig.now_us);
  FrameFeeder feeder(rig, Service::nmt);
  demand(rig.node_id() == unconfigured || (1 <= rig.node_id() && rig.node_id() <= 127));
  demand(feeder.feed(Bytes(8, 31)));
  if (good) {
    const Bytes first = image_of(rig);
    demand(rig.servo.start(first, rig.now_us) && image_of(rig) == first);
  }
  // Without a node-id it hears no NMT.
  demand(rig.node_id() == unconfigured || feeder.comes_back());
  return 0;
}
