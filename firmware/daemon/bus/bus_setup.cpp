#include "firmware/daemon/bus/bus_setup.hpp"

namespace smaservo::daemon {

canopen::ServoConfig config_of(const BusSetup& setup, std::span<float> recorder,
                               std::string_view eds) {
  canopen::ServoConfig config{};
  config.node.device_name = "smaservo";
  config.node.hardware_version = setup.board;
  config.node.eds = eds;
  config.node.software_version = SMASERVO_VERSION;
  config.recorder = recorder;
  config.ceilings = setup.ceilings;
  config.keys = setup.keys;
  config.unattended = setup.unattended;
  return config;
}

canopen::LoopTiming timing_of(const LoopFigures& figures) {
  const LoopFigures& f = figures;
  const auto count = [](const auto& x) { return static_cast<std::uint32_t>(x.load()); };
  const auto s = [](auto ns) { return 1e-9F * static_cast<float>(ns); };
  return {count(f.cycles),    count(f.missed),          s(f.wake.mean_ns()),
          s(f.wake.max_ns()), s(f.execution.mean_ns()), s(f.execution.max_ns())};
}

}  // namespace smaservo::daemon
