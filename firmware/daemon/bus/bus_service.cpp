#include "firmware/daemon/bus/bus_service.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <poll.h>
#include <thread>
#include <vector>

#include "firmware/canopen/servo/servo.hpp"
#include "firmware/daemon/bus/bus_journal.hpp"
#include "firmware/daemon/bus/kept_settings.hpp"
#include "firmware/daemon/bus/request_desk.hpp"
#include "firmware/daemon/bus/settings_link.hpp"
#include "firmware/daemon/process/realtime.hpp"
#include "firmware/text/reference/canopen_reference.hpp"
#include "hal/linux/can/open_can.hpp"
#include "hal/linux/system/clock.hpp"
#include "model/files/error.hpp"
#include "model/files/message.hpp"
#include "model/files/output_file.hpp"

namespace smaservo::daemon {
namespace {

using canopen::Request;

constexpr int round_ms = 1;
constexpr double thread_lease_s = 0.1;
constexpr std::size_t recorder_values = 65536;

/// Empty: there is no such file. One that has nothing in it, or cannot be read, is a damaged
/// image.
Image read_image(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  const Image image{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  std::error_code unknown;
  const bool is_missing = !file.is_open() && !std::filesystem::exists(path, unknown) && !unknown;
  return image.empty() && !is_missing ? Image(1) : image;
}

/// Returns what went wrong; empty: there is no such file, and there will be none after a loss of
/// power.
std::string remove_durably(const std::string& path) {
  std::error_code error;
  std::filesystem::remove(path, error);
  if (error) {
    return fmt::format("{}: cannot be removed: {}", path, error.message());
  }
  return files::sync_folder_of(path)
             ? ""
             : fmt::format("{}: a loss of power may bring it back: {}", path, std::strerror(errno));
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
  config.unattended = setup.unattended;
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
        pump(port, servo, source),
        settings(servo, staging, desk_, links_),
        store([this](const StoreJob& job) { return keep(job); }),
        requests(servo, store) {}

  std::string image_path() const { return setup.folder + "/communication"; }
  void begin(std::uint64_t now_us) {
    const Image image = setup.folder.empty() ? Image{} : read_image(image_path());
    image_lost = !servo.start(image, now_us);
    if (image_lost) {
      files::complain("smaservod",
                      image_path() +
                          ": is damaged; the bus starts with its default settings, and "
                          "the device cannot be armed before they are stored (1010h) "
                          "or restored (1011h)");
    }
  }
  void run(const std::stop_token& stop);
  FaultSet faults(std::uint64_t now_us);
  void show_figures();
  void tell_changes();
  void carry_out(Request reset, std::uint64_t now_us);
  void stored(const StoreResult& result);
  std::string keep(const StoreJob& job) const;

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
  bool image_lost = false;  ///< the image is damaged: the bus has its defaults
  SettingsLink settings;
  StoreThread store;
  RequestDesk<canopen::Servo<double>, StoreThread> requests;
  std::uint64_t heard_us = 0, frames = 0;
  std::jthread thread;  // declared last: ends before what it uses
};

BusService::BusService(const BusSetup& setup, ParameterDesk& desk, LoopLinks& links,
                       const LoopFigures& figures)
    : parts_(std::make_unique<Parts>(setup, desk, links, figures)) {}
BusService::~BusService() {
  parts_->desk.reloads().set_bus(false);
}

CommandSource& BusService::command_source() {
  return parts_->source;
}

void BusService::start() {
  parts_->desk.reloads().set_bus(true);
  parts_->thread = std::jthread([this](const std::stop_token& stop) { parts_->run(stop); });
}

void BusService::Parts::run(const std::stop_token& stop) {
  const auto now = [] { return static_cast<std::uint64_t>(hal::monotonic_ns() / 1000); };
  name_thread("bus");
  // The warnings are not needed: the loop's thread warns of the same missing rights.
  if (setup.priority > 0) {
    make_real_time({.priority = setup.priority});
  }
  begin(now());
  for (const LostValue& lost : setup.lost) {
    servo.note_change(lost.key, lost.stored, lost.in_force, canopen::Source::device);
    tell_changes();
  }
  heard_us = now();
  while (!stop.stop_requested()) {
    pollfd readable{port.descriptor(), POLLIN, 0};
    poll(&readable, 1, pump.has_more() ? 0 : round_ms);
    const std::uint64_t now_us = now();
    show_figures();
    settings.before_round(requests.is_busy());
    pump.round(now_us, faults(now_us), [&] { return settings.give_to_desk(); });
    tell_changes();
    carry_out(requests.round([this] { return staging.configured(); },
                             [this](const StoreResult& result) { stored(result); }),
              now_us);
  }
}

FaultSet BusService::Parts::faults(std::uint64_t now_us) {
  if (pump.frames() != frames) {
    frames = pump.frames();
    heard_us = now_us;
  }
  const hal::CanState state = port.state();
  const bool silent =
      setup.lost_after_s > 0 && static_cast<double>(now_us - heard_us) * 1e-6 > setup.lost_after_s;
  FaultSet set;
  set.add(Fault::store_outdated, image_lost);
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

void BusService::Parts::tell_changes() {
  canopen::LoggedChange change{};
  while (servo.take_change(change)) {
    journal.add(change);
  }
  journal.set_count(servo.objects().changes);
}

void BusService::Parts::carry_out(Request reset, std::uint64_t now_us) {
  if (reset == Request::reset_communication) {
    begin(now_us);
  } else if (reset == Request::reset_node) {
    // The node sends no more and withdraws its arm command; the loop ends in its next cycle.
    links.restart.store(true);
    links.stop.store(true);
  }
}

/// Whoever stores has seen what is in force: that acknowledges a store that was not whole, and
/// makes it whole. Restored settings are in force after a reset only; until then the older ones
/// still are.
void BusService::Parts::stored(const StoreResult& result) {
  if (!result.problem.empty()) {
    files::complain("smaservod: storing", result.problem);
    return;
  }
  using enum Request;
  const Request r = result.request;
  if (r == store_all || r == store_application) {
    settings.note_stored(true);
    links.faults.fetch_and(~FaultSet(Fault::store_outdated).bits());
  }
  if (r == restore_all || r == restore_application) {
    settings.note_stored(false);
  }
  image_lost = image_lost && (r == store_application || r == restore_application);
}

std::string BusService::Parts::keep(const StoreJob& job) const {
  if (setup.folder.empty()) {
    return "there is no folder to store in; give one with --settings";
  }
  using enum Request;
  std::string problem;
  switch (job.request) {
    case store_all:
      problem = store_settings(setup.folder, job.settings);
      return problem.empty() ? write_image(image_path(), job.image) : problem;
    case store_application:
      return store_settings(setup.folder, job.settings);
    case store_lss:
      // That would make the defaults of all others look like what somebody has stored.
      return image_lost ? image_path() + " is damaged: store (1010h) or restore (1011h) first"
                        : write_image(image_path(), job.image);
    case store_communication:
      return write_image(image_path(), job.image);
    case restore_all:
      problem = remove_durably(image_path());
      return problem.empty() ? forget_settings(setup.folder) : problem;
    case restore_application:
      return forget_settings(setup.folder);
    case restore_communication:
      return remove_durably(image_path());
    default:
      return "the request is not supported";
  }
}

}  // namespace smaservo::daemon
