#include "firmware/daemon/bus/bus_service.hpp"

#include <poll.h>
#include <thread>

#include "firmware/daemon/bus/bus_journal.hpp"
#include "firmware/daemon/bus/bus_rounds.hpp"
#include "firmware/daemon/process/realtime.hpp"
#include "hal/linux/can/open_can.hpp"
#include "hal/linux/system/clock.hpp"

namespace smaservo::daemon {
namespace {

constexpr int round_ms = 1;

std::uint64_t now_us() {
  return static_cast<std::uint64_t>(hal::monotonic_ns() / 1000);
}

}  // namespace

struct BusService::Parts {
  Parts(const BusSetup& setup, ParameterDesk& desk_, LoopLinks& links, const LoopFigures& figures)
      : priority(setup.priority),
        desk(desk_),
        port(hal::open_can(setup.interface)),
        rounds(setup, desk, links, figures, port, journal) {}

  void run(const std::stop_token& stop);

  int priority;
  ParameterDesk& desk;
  hal::LinuxCan port;
  BusJournal journal;
  BusRounds<hal::LinuxCan, StoreThread, BusJournal> rounds;
  std::jthread thread;  // declared last, so that it ends before the members that it uses
};

BusService::BusService(const BusSetup& setup, ParameterDesk& desk, LoopLinks& links,
                       const LoopFigures& figures)
    : parts_(std::make_unique<Parts>(setup, desk, links, figures)) {}
BusService::~BusService() {
  parts_->desk.reloads().set_bus(false);
}

CommandSource& BusService::command_source() {
  return parts_->rounds.source();
}

void BusService::start() {
  parts_->desk.reloads().set_bus(true);
  parts_->thread = std::jthread([this](const std::stop_token& stop) { parts_->run(stop); });
}

void BusService::Parts::run(const std::stop_token& stop) {
  name_thread("bus");
  // The warnings are dropped: the loop's thread warns of the same missing rights.
  if (priority > 0) {
    make_real_time({.priority = priority});
  }
  rounds.start(now_us());
  while (!stop.stop_requested()) {
    pollfd readable{port.descriptor(), POLLIN, 0};
    poll(&readable, 1, rounds.has_more() ? 0 : round_ms);
    rounds.round(now_us());
  }
}

}  // namespace smaservo::daemon
