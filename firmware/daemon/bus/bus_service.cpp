#include "firmware/daemon/bus/bus_service.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <future>
#include <poll.h>
#include <thread>
#include <vector>

#include "firmware/canopen/servo/servo.hpp"
#include "firmware/daemon/bus/bus_journal.hpp"
#include "firmware/daemon/bus/kept_settings.hpp"
#include "firmware/daemon/process/realtime.hpp"
#include "firmware/text/reference/canopen_reference.hpp"
#include "hal/linux/can/open_can.hpp"
#include "hal/linux/system/clock.hpp"
#include "model/files/error.hpp"
#include "model/files/output_file.hpp"

namespace smaservo::daemon {
namespace {

using canopen::Request;
using Image = std::vector<std::uint8_t>;

constexpr int round_ms = 1;
constexpr double thread_lease_s = 0.1;
constexpr std::size_t recorder_values = 65536;

Image read_image(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

/// Returns what went wrong; empty: the file is durable.
std::string write_image(const std::string& path, const Image& image) {
  try {
    files::OutputFile file(path);
    file.write({reinterpret_cast<const char*>(image.data()),  // NOLINT(*-reinterpret-cast): bytes
                image.size()});
    file.commit();
    return {};
  } catch (const files::UserError& error) {
    return error.what();
  }
}

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
  return config;
}

canopen::LoopTiming timing_of(const LoopFigures& f) {
  const auto count = [](const auto& x) { return static_cast<std::uint32_t>(x.load()); };
  const auto s = [](auto ns) { return 1e-9F * static_cast<float>(ns); };
  return {count(f.cycles),    count(f.missed),          s(f.wake.mean_ns()),
          s(f.wake.max_ns()), s(f.execution.mean_ns()), s(f.execution.max_ns())};
}

}  // namespace

struct BusService::Parts {
  Parts(const BusSetup& setup_, ParameterDesk& desk_, LoopLinks& links_,
        const LoopFigures& figures_)
      : setup(setup_),
        desk(desk_),
        links(links_),
        figures(figures_),
        port(hal::open_can(setup_.interface)),
        recorder(recorder_values),
        eds(text::eds_text()),
        staging(desk_.settings()),
        servo(config_of(setup, recorder, eds), staging),
        source(thread_lease_s),
        pump(port, servo, source) {}

  std::string image_path() const { return setup.folder + "/communication"; }
  void begin(std::uint64_t now_us) {
    const Image image = setup.folder.empty() ? Image{} : read_image(image_path());
    if (!servo.start(image, now_us)) {
      fmt::print(stderr, "smaservod: {}: is damaged; the bus starts with its default settings\n",
                 image_path());
    }
  }
  void run(const std::stop_token& stop);
  FaultSet faults(std::uint64_t now_us);
  void show_figures();
  void tell_changes();
  void follow_desk();
  bool give_to_desk();
  void answer(Request request, std::uint64_t now_us);
  std::string keep(Request request, const Settings<double>& settings, const Image& image) const;

  BusSetup setup;
  ParameterDesk& desk;
  LoopLinks& links;
  const LoopFigures& figures;
  hal::LinuxCan port;
  std::vector<float> recorder;
  std::string eds;
  Staging<double> staging;
  canopen::Servo<double> servo;
  BusCommandSource source;
  BusPump<hal::LinuxCan, canopen::Servo<double>> pump;
  BusJournal journal;
  std::future<std::string> storing;
  std::uint64_t heard_us = 0, frames = 0;
  std::uint32_t followed = 0;  ///< number of the desk's last change that the node has
  std::jthread thread;         // declared last: ends before what it uses
};

BusService::BusService(const BusSetup& setup, ParameterDesk& desk, LoopLinks& links,
                       const LoopFigures& figures)
    : parts_(std::make_unique<Parts>(setup, desk, links, figures)) {}
BusService::~BusService() = default;

CommandSource& BusService::command_source() {
  return parts_->source;
}

void BusService::start() {
  parts_->thread = std::jthread([this](const std::stop_token& stop) { parts_->run(stop); });
}

void BusService::Parts::run(const std::stop_token& stop) {
  const auto now = [] { return static_cast<std::uint64_t>(hal::monotonic_ns() / 1000); };
  // The warnings are not needed: the loop's thread warns of the same missing rights.
  if (setup.priority > 0) {
    make_real_time({.priority = setup.priority});
  }
  begin(now());
  heard_us = now();
  while (!stop.stop_requested()) {
    pollfd readable{port.descriptor(), POLLIN, 0};
    poll(&readable, 1, pump.has_more() ? 0 : round_ms);
    const std::uint64_t now_us = now();
    show_figures();
    follow_desk();
    pump.round(now_us, faults(now_us), [&] { return give_to_desk(); });
    tell_changes();
    const Request request = servo.request();
    if (request != Request::none) {
      answer(request, now_us);
    }
  }
}

FaultSet BusService::Parts::faults(std::uint64_t now_us) {
  if (pump.frames() != frames) {
    frames = pump.frames();
    heard_us = now_us;
  }
  const hal::CanState state = port.state();
  const bool silent =
      setup.command_source_timeout_s > 0 &&
      static_cast<double>(now_us - heard_us) * 1e-6 > setup.command_source_timeout_s;
  FaultSet set;
  set.add(Fault::bus_lost, silent || state == hal::CanState::bus_off ||
                               state == hal::CanState::down || state == hal::CanState::gone);
  return set;
}

void BusService::Parts::show_figures() {
  servo.set_timing(timing_of(figures));
  servo.set_bus(static_cast<std::uint32_t>(pump.dropped()),
                static_cast<std::uint32_t>(port.statistics().bus_offs),
                static_cast<std::uint32_t>(pump.queue_full()));
}

/// Gives the node the settings that SIGHUP has put in force, so that clients read and change those.
void BusService::Parts::follow_desk() {
  const std::uint32_t changes = desk.changes();
  if (followed != changes) {
    followed = changes;
    servo.replace_settings(desk.settings());
  }
}

bool BusService::Parts::give_to_desk() {
  const std::optional<std::uint32_t> number = desk.change(staging.active());
  followed = number.value_or(followed);
  return number.has_value();
}

void BusService::Parts::tell_changes() {
  canopen::LoggedChange change{};
  while (servo.take_change(change)) {
    journal.add(change);
  }
  journal.set_count(servo.objects().changes);
}

/// Does what the node requests. It stores in a thread of its own, since a disk may be slow: the bus
/// goes on meanwhile, and the answer to the client follows.
void BusService::Parts::answer(Request request, std::uint64_t now_us) {
  if (request == Request::reset_communication) {
    begin(now_us);
    return;
  }
  if (request == Request::reset_node) {
    // The node sends no more and withdraws its arm command; the loop ends in its next cycle.
    links.restart.store(true);
    links.stop.store(true);
    return;
  }
  if (!storing.valid()) {
    Image image(canopen::Node::image_size);
    image.resize(servo.image(image));
    storing = std::async(std::launch::async,
                         [this, request, settings = staging.configured(),
                          image = std::move(image)] { return keep(request, settings, image); });
    return;
  }
  if (storing.wait_for(std::chrono::seconds(0)) == std::future_status::ready) {
    const std::string problem = storing.get();
    if (!problem.empty()) {
      fmt::print(stderr, "smaservod: storing: {}\n", problem);
    }
    servo.finish(problem.empty());
  }
}

std::string BusService::Parts::keep(Request request, const Settings<double>& settings,
                                    const Image& image) const {
  if (setup.folder.empty()) {
    return "there is no folder to store in; give one with --settings";
  }
  std::string problem;
  std::error_code error;
  switch (request) {
    case Request::store_all:
      problem = store_settings(setup.folder, settings);
      return problem.empty() ? write_image(image_path(), image) : problem;
    case Request::store_application:
      return store_settings(setup.folder, settings);
    case Request::store_communication:
    case Request::store_lss:
      return write_image(image_path(), image);
    case Request::restore_all:
      std::filesystem::remove(image_path(), error);
      return forget_settings(setup.folder);
    case Request::restore_application:
      return forget_settings(setup.folder);
    case Request::restore_communication:
      std::filesystem::remove(image_path(), error);
      return error ? error.message() : "";
    default:
      return "the request is not supported";
  }
}

}  // namespace smaservo::daemon
