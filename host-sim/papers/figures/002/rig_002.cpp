#include "host-sim/papers/figures/002/rig_002.hpp"

#include <functional>

namespace smaservo::figures::bench_002 {
namespace {

constexpr double on_share = 0.8;  // share of the maker's current: the whole wire transforms in 2 s

double on_A() {
  static const double current_A = on_share * wire().wire.limits.current_A;
  return current_A;
}

/// Steps the rig and records every fifth row.
class Recorder {
 public:
  explicit Recorder(Rig& rig) : rig_(rig) {}

  void run(bool heats, double max_s, const std::function<bool(double strain)>& done) {
    for (const double stop_s = rig_.time_s() + max_s;
         rig_.time_s() < stop_s && !done(rig_.strain());) {
      const double time_s = rig_.time_s();
      const RigRow row{time_s, rig_.strain(), rig_.resistance_ohm(), rig_.temperature_K(), heats};
      const Measurement<double> m = rig_.step(heats ? on_A() : min_current_A);
      if (tick_++ % 5 == 0) {
        loops.rows.push_back(row);
        loops.run.time_s.push_back(row.time_s);
        loops.run.strain.push_back(row.strain);
        loops.run.resistance_ohm.push_back(m.resistance_ohm);
        loops.run.stress_Pa.push_back(m.stress_Pa);
      }
    }
  }
  void fully(bool heats) {
    run(heats, heats ? 4 : 9, [](double) { return false; });
  }
  void clear() { loops = {}; }

  MinorLoops loops{};

 private:
  Rig& rig_;
  long tick_ = 0;
};

}  // namespace

Rig::Rig(hal::Family family, const hal::Load& load)
    : area_m2_(wire().wire.geometry.area_m2()),
      load_(load),
      wire_(hal::make_simulated_wire(family, wire().wire, {}, 0.5, random_)) {
  wire_->rest(ambient_K, load_.stress_Pa());
}

Measurement<double> Rig::step(double current_A) {
  load_.advance(time_s_, step_s, wire_->strain(), random_);
  const hal::Readings r = hal::read_sensors(sensors(), current_A, wire_->resistance_ohm(),
                                            load_.stress_Pa() * area_m2_, normal_, random_);
  wire_->advance(current_A, {load_.stress_Pa(), ambient_K, 1}, step_s);
  time_s_ += step_s;
  return {r.voltage_V / r.current_A, 0, 0, r.load_N / area_m2_, true, false, true};
}

std::vector<RigRow> major_loop(hal::Family family, double load_N) {
  Rig rig(family, hal::ConstantLoad{stress_Pa(load_N)});
  Recorder recorder(rig);
  recorder.fully(true);
  recorder.fully(false);
  recorder.clear();
  recorder.fully(true);
  recorder.fully(false);
  return recorder.loops.rows;
}

MinorLoops minor_loops(hal::Family family, double load_N, bool incomplete_cooling) {
  Rig rig(family, hal::ConstantLoad{stress_Pa(load_N)});
  Recorder recorder(rig);
  recorder.fully(true);
  const double shortest = rig.strain();
  recorder.fully(false);
  const double longest = rig.strain();
  recorder.clear();
  recorder.fully(true);
  if (!incomplete_cooling) {
    recorder.fully(false);
  }
  for (const double share : {0.15, 0.3, 0.45, 0.6, 0.75, 0.9}) {
    const bool heats = !incomplete_cooling;
    const double goal =
        heats ? longest - share * (longest - shortest) : shortest + share * (longest - shortest);
    recorder.run(heats, 20, [&](double strain) { return heats ? strain < goal : strain > goal; });
    recorder.fully(!heats);
  }
  recorder.loops.run.name = incomplete_cooling ? "incomplete cooling" : "incomplete heating";
  recorder.loops.run.kind = identify::RunKind::joule;
  return recorder.loops;
}

}  // namespace smaservo::figures::bench_002
