#include "host-sim/commission/live/live.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <memory>

#include "host-sim/can/bus/port_bus.hpp"
#include "host-sim/commission/live/heated_servo.hpp"
#include "host-sim/commission/live/terminal.hpp"
#include "host-sim/end_by_signal.hpp"
#include "host-sim/record/bus_run.hpp"
#include "model/files/error.hpp"
#include "model/files/message.hpp"
#include "model/files/output_file.hpp"
#include "model/units.hpp"

namespace smaservo::commission {
namespace {

/// Between two looks at the servo; a look is five to nine requests.
constexpr std::int64_t look_us = 50'000;
constexpr std::int64_t draw_us = 250'000;
/// The last part of a level, in which the wire is at rest, and at most half of the level.
constexpr double settled_s = 1;
/// The recording's time beyond the sequence: bus and machine may be slow.
constexpr double spare_s = 5;
/// The wanted time between rows. A servo with less memory records more slowly, ...
constexpr double wanted_period_s = 0.01;
/// ... but not so slowly that a level has no shape any more.
constexpr double most_period_s = 0.05;
/// Signals besides the readings, the most useful first, where the memory has room.
constexpr std::array other_signals{"strain", "wire_temperature_K"};

class SumOfLooks {
 public:
  void add(const Means& look) {
    if (std::isfinite(look.current_A) && std::isfinite(look.voltage_V)) {
      sum_.current_A += look.current_A;
      sum_.voltage_V += look.voltage_V;
      sum_.stress_Pa += look.stress_Pa;
      ++count_;
    }
  }
  /// NaN if no look had readings.
  Means mean() const {
    return {sum_.current_A / count_, sum_.voltage_V / count_, sum_.stress_Pa / count_};
  }

 private:
  Means sum_{0, 0, 0};
  double count_ = 0;
};

class GuidedRun {
 public:
  GuidedRun(const LiveOptions& options, can::Remote& remote, Person& person)
      : options_(options), remote_(remote), bus_(remote.bus()), person_(person), servo_(remote) {}

  record::BusRun run() {
    servo_.require_free();
    readings_ = std::make_unique<Readings>(options_.reading_sd_m,
                                           servo_.device().settings.wire.geometry.length_m);
    // With the nominal resistance: what the limits do not allow is said before anybody reads.
    plan(servo_.device().cold_ohm);
    ask_cold();
    note_slow_wire();
    if (!sequence_.whole) {
      notes_.push_back(fmt::format(
          "the limits allow {:.0f} degC only, at which the wire of the settings transforms in part",
          sequence_.top_K - zero_degC_K));
    }
    try {
      servo_.begin();
      arm();
      heat();
      end_recording();
    } catch (const std::exception& error) {
      throw files::UserError(error.what() + servo_.put_back());
    }
    const std::string after = servo_.put_back();
    person_.show("reading the recording ...");
    record::BusRun run = record::read_run(remote_, recorded_);
    if (after != "; the heat is off") {
      notes_.push_back(after.substr(2));
    }
    return run;
  }

  const std::vector<Anchor>& anchors() const { return readings_->anchors(); }
  std::vector<std::string>& notes() { return notes_; }

 private:
  void plan(double cold_ohm) {
    sequence_ = plan_sequence(servo_.device(), {servo_.stress_Pa(), servo_.ambient_K(), cold_ohm},
                              options_.times, asks());
  }
  /// Without the cold reading the others mean nothing.
  std::size_t asks() {
    const bool answers = person_.is_there() && options_.questions;
    return answers && (!cold_asked_ || readings_->has_zero())
               ? std::min(options_.asks, most_questions)
               : 0;
  }

  void ask_cold() {
    if (options_.questions && person_.is_there()) {
      person_.say(fmt::format(
          "read the cold wire, under its load and before any heat: it is the zero of all readings; "
          "{:.0f} s",
          options_.cold_wait_s));
      Question question(person_, *readings_, bus_.now_us() + micros(options_.cold_wait_s));
      while (!question.look(bus_.now_us(), 0)) {
        wait();
      }
    }
    cold_asked_ = true;
    if (options_.questions && !readings_->has_zero()) {
      notes_.emplace_back("no cold reading: there are no anchors");
    }
    plan(servo_.device().cold_ohm);
  }

  /// A level must last some time constants of the wire in air, or the wire does not get to where
  /// its power would hold it.
  void note_slow_wire() {
    constexpr double constants_per_level = 1.5;
    const auto& body = servo_.device().observer.model.body;
    const double time_constant_s = body.capacity_J_K / body.loss_W_K;
    if (options_.times.up_s < constants_per_level * time_constant_s) {
      notes_.push_back(
          fmt::format("the wire takes {:.2g} s to follow its power, and a level lasts {:.2g} s: it "
                      "may not have "
                      "transformed wholly",
                      time_constant_s, options_.times.up_s));
    }
  }

  /// The recording of the whole run, at the highest rate that fits into the servo's memory.
  void arm() {
    recorded_.seconds =
        sequence_.seconds() + static_cast<double>(asks()) * options_.hold_s + spare_s;
    for (std::size_t others = other_signals.size() + 1; others-- > 0;) {
      const auto* const end = other_signals.begin() + static_cast<std::ptrdiff_t>(others);
      recorded_.signals = record::signals_with({other_signals.begin(), end});
      servo_.record(recorded_);
      period_s_ = remote_.number("recorder.period_s");
      // The device sends its period as a float.
      if (period_s_ <= wanted_period_s * (1 + 1e-6)) {
        return;
      }
    }
    if (!(period_s_ <= most_period_s)) {
      throw files::UserError(fmt::format(
          "node {}: its recorder has room for {:.0f} rows, one each {:.3g} s in {:.0f} s; it must "
          "be one each {} s",
          remote_.node(), remote_.number("recorder.capacity"), period_s_, recorded_.seconds,
          most_period_s));
    }
    notes_.push_back(
        fmt::format("the servo's memory has room for {:.0f} rows/s only", 1 / period_s_));
  }

  /// While the servo is still enabled, so that every row has a current.
  void end_recording() {
    constexpr std::uint32_t records = 2;
    if (remote_.whole("recorder.state") != records) {
      throw files::UserError(fmt::format(
          "node {}: its recorder has stopped after {:.1f} s: somebody else has used it, "
          "or the servo was late",
          remote_.node(), run_time_s()));
    }
    remote_.set("recorder.command", "0");
    recorded_.seconds = run_time_s();
  }

  void heat() {
    for (std::size_t i = 0; i < sequence_.levels.size(); ++i) {
      const Level level = sequence_.levels[i];
      servo_.set_power(level.power_W, level.kind != LevelKind::rest);
      const Means settled = stay(i);
      if (level.kind == LevelKind::rest) {
        judge_rest(settled);
        plan(cold_.resistance_ohm());
      }
      const bool first_hot_end = sequence_.first_transforms
                                     ? level.kind == LevelKind::first
                                     : level.cycle == 2 && level.kind == LevelKind::up &&
                                           sequence_.levels[i + 1].kind == LevelKind::down;
      if (first_hot_end) {
        require(judge_response(cold_, settled, servo_.limited_by()));
      }
      if (level.asks) {
        hold(level);
      }
    }
  }

  void judge_rest(const Means& settled) {
    cold_ = settled;
    require(judge_load(servo_.device(), settled.stress_Pa));
    require(judge_leads(servo_.device(), settled));
    require(judge_cold(servo_.device(), settled, servo_.ambient_K()));
  }

  /// Stays at a level; the means are those of its end.
  Means stay(std::size_t level) {
    const double seconds = sequence_.levels[level].seconds;
    const std::int64_t until_us = bus_.now_us() + micros(seconds);
    const std::int64_t settled_us = until_us - micros(std::min(settled_s, seconds / 2));
    SumOfLooks settled;
    std::int64_t now_us = bus_.now_us();
    bool counted = false;
    // At least one look counts, however slow the bus is.
    for (; now_us < until_us || !counted; now_us = bus_.now_us()) {
      const Means look = servo_.look();
      if (now_us >= settled_us) {
        settled.add(look);
        counted = true;
      }
      draw(level, look, static_cast<double>(until_us - now_us) * 1e-6);
      wait();
    }
    return settled.mean();
  }

  void hold(const Level& level) {
    person_.say(
        fmt::format("the heat is held for {:.0f} s at most: read the displacement of the "
                    "{} wire",
                    options_.hold_s, level.kind == LevelKind::up ? "heated" : "cooling"));
    Question question(person_, *readings_, bus_.now_us() + micros(options_.hold_s));
    while (!question.look(bus_.now_us(), run_time_s())) {
      servo_.look();
      wait();
    }
  }

  void draw(std::size_t level, const Means& look, double left_s) {
    if (bus_.now_us() < draw_at_us_) {
      return;
    }
    draw_at_us_ = bus_.now_us() + draw_us;
    for (std::size_t i = level + 1; i < sequence_.levels.size(); ++i) {
      left_s += sequence_.levels[i].seconds;
    }
    person_.show(fmt::format("{}: {:.4g} mA, {:.4g} ohm, {:.3g} MPa; {:.0f} s left",
                             level_text(sequence_, level), 1e3 * look.current_A,
                             look.resistance_ohm(), look.stress_Pa / 1e6, std::max(left_s, 0.0)));
  }

  /// Time of the recording, by its rows: that of the file.
  double run_time_s() { return remote_.number("recorder.samples") * period_s_; }

  void wait() {
    if (EndBySignal::came()) {
      throw files::UserError("ended by a signal; nothing is written");
    }
    hal::CanFrame passing;
    const std::int64_t until_us = bus_.now_us() + look_us;
    while (bus_.receive(passing, until_us)) {
    }
  }

  void require(const std::string& wrong) const {
    if (!wrong.empty()) {
      throw files::UserError(fmt::format("node {}: {}", remote_.node(), wrong));
    }
  }
  static std::int64_t micros(double seconds) { return std::llround(seconds * 1e6); }

  const LiveOptions& options_;
  can::Remote& remote_;
  can::Bus& bus_;
  Person& person_;
  HeatedServo servo_;
  std::unique_ptr<Readings> readings_;
  bool cold_asked_ = false;
  Sequence sequence_{};
  can::RecordingPlan recorded_;
  double period_s_ = 0;
  Means cold_{};
  std::int64_t draw_at_us_ = 0;
  std::vector<std::string> notes_;
};

}  // namespace

LiveRun record_live(const LiveOptions& options, can::Remote& remote, Person& person) {
  // Where it cannot be written, that is found before any heat.
  files::OutputFile file(options.path);
  GuidedRun guided(options, remote, person);
  const record::BusRun run = guided.run();
  file.write(run.csv);
  file.commit();
  LiveRun done{options.path,           guided.anchors(),  run.recording.rows.size(), run.left_out,
               run.recording.period_s, run.longest_gap_s, std::move(guided.notes())};
  return done;
}

LiveRun record_live(const LiveOptions& options) {
  const EndBySignal guard;
  try {
    can::PortBus bus(options.can);
    can::Remote remote({bus, options.node});
    remote.client().set_timeout(static_cast<std::int64_t>(options.timeout_s * 1e6));
    if (options.key) {
      remote.set("access.key", std::to_string(*options.key));
    }
    TerminalPerson person(options.questions);
    return record_live(options, remote, person);
  } catch (const std::exception& error) {
    // The signal ends this program once the guard has gone, and nobody else could say this.
    if (EndBySignal::came()) {
      files::complain("host-sim", error.what());
    }
    throw;
  }
}

std::string anchors_csv(const std::vector<Anchor>& anchors) {
  std::string csv = "time_s,displacement_m,sd_m\n";
  for (const Anchor& anchor : anchors) {
    csv += fmt::format("{:.6f},{:.9g},{:.9g}\n", anchor.time_s, anchor.displacement_m, anchor.sd_m);
  }
  return csv;
}

}  // namespace smaservo::commission
