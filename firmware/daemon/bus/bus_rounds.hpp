#pragma once
// The work of the bus's thread, one round after the other. Time is an argument and nothing blocks,
// so that a test can step through it.

#include <cstdint>
#include <string>
#include <vector>

#include "firmware/canopen/servo/servo.hpp"
#include "firmware/daemon/bus/bus_files.hpp"
#include "firmware/daemon/bus/bus_pump.hpp"
#include "firmware/daemon/bus/bus_setup.hpp"
#include "firmware/daemon/bus/request_desk.hpp"
#include "firmware/daemon/bus/settings_link.hpp"
#include "firmware/text/canopen/canopen_reference.hpp"
#include "model/files/message.hpp"

namespace smaservo::daemon {

/// `Port` is hal::LinuxCan, `Store` StoreThread, `Journal` BusJournal, or classes with the same
/// members. All functions except source() are for the bus's thread.
template <hal::CanPort Port, class Store, class Journal>
class BusRounds {
 public:
  BusRounds(const BusSetup& setup, ParameterDesk& desk, LoopLinks& links,
            const LoopFigures& figures, Port& port, Journal& journal)
      : setup_(setup),
        links_(links),
        figures_(figures),
        port_(port),
        journal_(journal),
        files_(setup.folder),
        recorder_(recorder_values),
        eds_(text::eds_text()),
        staging_(desk),
        servo_(config_of(setup_, recorder_, eds_), staging_),
        source_(lease_s),
        pump_(port, servo_, source_),
        settings_(servo_, staging_, desk, links),
        store_([this](const StoreJob& job) { return files_.keep(job, image_lost_); }),
        requests_(servo_, store_) {}
  ~BusRounds() = default;
  BusRounds(const BusRounds&) = delete;
  BusRounds& operator=(const BusRounds&) = delete;

  /// To be called before the first round.
  void start(std::uint64_t now_us) {
    begin(now_us);
    for (const LostValue& lost : setup_.lost) {
      servo_.note_change(lost.key, lost.stored, lost.in_force, canopen::Source::device);
      tell_changes();
    }
    heard_us_ = now_us;
  }

  void round(std::uint64_t now_us) {
    servo_.set_timing(timing_of(figures_));
    servo_.set_bus(static_cast<std::uint32_t>(pump_.dropped()),
                   static_cast<std::uint32_t>(port_.statistics().bus_offs),
                   static_cast<std::uint32_t>(pump_.queue_full()));
    settings_.before_round(requests_.is_busy());
    pump_.round(now_us, faults(now_us), [&] { settings_.give(); });
    tell_changes();
    carry_out(requests_.round([this] { return staging_.configured(); },
                              [this](const StoreResult& result) { stored(result); }),
              now_us);
  }

  /// Whether the next round must follow at once; otherwise it follows when a frame has come, or
  /// after a millisecond.
  bool has_more() const { return pump_.has_more(); }
  BusCommandSource& source() { return source_; }
  Store& store() { return store_; }

 private:
  /// Time without a round after which the loop ends the heat.
  static constexpr double lease_s = 0.1;
  static constexpr std::size_t recorder_values = 65536;

  void begin(std::uint64_t now_us) {
    image_lost_ = !servo_.start(files_.image(), now_us);
    if (image_lost_) {
      files::complain("smaservod",
                      files_.image_path() +
                          ": is damaged; the bus starts with its default settings, and "
                          "the device cannot be armed before they are stored (1010h) "
                          "or restored (1011h)");
    }
  }

  FaultSet faults(std::uint64_t now_us) {
    if (pump_.frames() != frames_) {
      frames_ = pump_.frames();
      heard_us_ = now_us;
    }
    const hal::CanState state = port_.state();
    const bool silent = setup_.lost_after_s > 0 &&
                        static_cast<double>(now_us - heard_us_) * 1e-6 > setup_.lost_after_s;
    FaultSet set;
    set.add(Fault::store_outdated, image_lost_);
    set.add(Fault::bus_lost, silent || state == hal::CanState::bus_off ||
                                 state == hal::CanState::down || state == hal::CanState::gone);
    return set;
  }

  void tell_changes() {
    canopen::LoggedChange change{};
    while (servo_.take_change(change)) {
      journal_.add(change);
    }
    journal_.set_count(servo_.objects().changes);
  }

  void carry_out(canopen::Request reset, std::uint64_t now_us) {
    if (reset == canopen::Request::reset_communication) {
      begin(now_us);
    } else if (reset == canopen::Request::reset_node) {
      // The node sends nothing more and withdraws its arm command; the loop ends in its next cycle.
      links_.restart.store(true);
      links_.stop.store(true);
    }
  }

  /// A user who stores settings has seen those in force: that acknowledges a damaged store and
  /// repairs it. Restored settings take effect only after a reset; until then the older ones stay
  /// in force.
  void stored(const StoreResult& result) {
    if (!result.problem.empty()) {
      files::complain("smaservod: storing", result.problem);
      return;
    }
    using enum canopen::Request;
    const canopen::Request r = result.request;
    if (r == store_all || r == store_application) {
      settings_.note_stored(true);
      links_.faults.fetch_and(~FaultSet(Fault::store_outdated).bits());
    }
    if (r == restore_all || r == restore_application) {
      settings_.note_stored(false);
    }
    image_lost_ = image_lost_ && (r == store_application || r == restore_application);
  }

  BusSetup setup_;
  LoopLinks& links_;
  const LoopFigures& figures_;
  Port& port_;
  Journal& journal_;
  BusFiles files_;
  std::vector<float> recorder_;
  std::string eds_;
  Staging<double> staging_;
  canopen::Servo<double> servo_;
  BusCommandSource source_;
  BusPump<Port, canopen::Servo<double>> pump_;
  SettingsLink settings_;
  /// The image is damaged: the bus has its defaults. Changes only while nothing is being stored.
  bool image_lost_ = false;
  std::uint64_t heard_us_ = 0, frames_ = 0;
  Store store_;
  RequestDesk<canopen::Servo<double>, Store> requests_;
};

}  // namespace smaservo::daemon
