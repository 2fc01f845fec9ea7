#include "host-sim/evaluate/closed_loop/random_scenario.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <utility>
#include <vector>

#include "firmware/bench/dice.hpp"
#include "firmware/text/device_names.hpp"
#include "firmware/text/settings_file.hpp"
#include "host-sim/evaluate/runs/calibrate.hpp"
#include "host-sim/evaluate/runs/electronics.hpp"
#include "host-sim/evaluate/runs/runs.hpp"
#include "model/units.hpp"
#include "model/wire/plant.hpp"

namespace smaservo::evaluate {
namespace {

constexpr std::array<std::string_view, random_air_count> air_names{
    "still", "draught", "gusts", "shielded", "ambient step", "weak",
    "lost",  "fading",  "fan",   "touched",  "wall"};
constexpr std::array<std::string_view, random_trouble_count> trouble_names{
    "none",           "load change", "load lost", "stuck",       "offset",
    "noise",          "gain",        "missing",   "lost frames", "weak supply",
    "weak converter", "broken",      "shorted",   "slip",        "reboot"};
constexpr std::array<std::string_view, 3> sensor_names{"current", "voltage", "load"};

/// Draws one scenario, part by part. Another order of the calls gives another scenario from the
/// same seed.
class Draw {
 public:
  Draw(const std::vector<CalibratedUnit>& units, std::uint64_t seed) : dice_(seed) {
    loop().name = fmt::format("random {}", seed);
    loop().seed = seed;
    const double length = dice_.uniform(0, 1);
    duration_s_ = length < 0.6 ? 20 : length < 0.95 ? 60 : 600;
    loop().duration_s = duration_s_;
    result_.air = draw_air();
    wire(units);
    settings();
    board();
    air();
    trouble();
    commands();
    find_halving();
  }
  RandomScenario scenario() const { return result_; }

 private:
  bench::ClosedLoopScenario& loop() { return result_.loop; }
  Settings<double>& device() { return result_.loop.settings; }

  /// A random number in 0..count - 1.
  std::size_t choice(std::size_t count) {
    return std::min(static_cast<std::size_t>(dice_.uniform(0, static_cast<double>(count))),
                    count - 1);
  }
  bool chance(double share) { return dice_.uniform(0, 1) < share; }
  double log_uniform(double low, double high) {
    return std::exp(dice_.uniform(std::log(low), std::log(high)));
  }
  double sign() { return dice_.coin() ? 1 : -1; }
  template <class... Parts>
  void note(fmt::format_string<Parts...> text, Parts&&... parts) {
    loop().note +=
        (loop().note.empty() ? "" : ", ") + fmt::format(text, std::forward<Parts>(parts)...);
  }

  /// Draws the true wire, and the wire file that the device gets.
  void wire(const std::vector<CalibratedUnit>& units) {
    const CalibratedUnit& known = units[choice(units.size())];
    bench::PlantSetup& plant = loop().plant;
    plant.seed = dice_.seed();
    if (chance(0.8)) {
      plant.family = bench::plant_family(known.unit.family);
      plant.wire = known.unit.wire;
      plant.scatter_K = known.unit.scatter_K;
      plant.structure = known.unit.structure;
      known_ = known.wire;
    } else {
      // A lumped plant whose loss and heat capacity have the errors that a calibration leaves.
      plant.family = bench::PlantFamily::lumped;
      plant.wire = files::load_wire(std::string(files::default_wire));
      known_ = dice_.coin() ? plant.wire.wire : known.wire;
      plant.wire.wire = known_;
      HeatParams<double>& heat = plant.wire.wire.heat;
      heat.convection_W_m2K *= dice_.factor(0.02);
      heat.specific_heat_J_kgK *= dice_.factor(0.04);
    }
    note("{} {}", bench::plant_name(plant.family), known.unit.seed);
    if (result_.air == RandomAir::fan) {
      fan_ = dice_.uniform(1, 3);
      known_.heat.convection_W_m2K *= fan_;
    }
  }

  void settings() {
    Settings<double>& s = device() = text::settings_for(known_);
    const double maker_A = known_.limits.current_A;
    const std::array<double, 3> currents_A{maker_A, 2 * maker_A, 0.4};
    s.limits.current_A = currents_A.at(choice(currents_A.size()));
    s.limits.power_W = 10;
    s.limits.temperature_K = zero_degC_K + dice_.uniform(100, 140);
    s.limits.max_strain = 0.06;
    s.trips.temperature_K = s.limits.temperature_K + 10;
    s.trips.current_A = 1.15 * s.limits.current_A;
    s.trips.max_strain = 0.08;
    s.limits.stress_Pa = known_.limits.stress_Pa;
    s.trips.stress_Pa = 1.2 * known_.limits.stress_Pa;
    s.safe.state = static_cast<SafeState>(choice(3));
    s.safe.hold_s = 5;
    s.drive.kind = chance(0.2) ? DriveKind::voltage : DriveKind::current;
    s.measurement.current_full_scale_A = 0.5;
    note("limit {:.0f} °C, {:.2f} A", s.limits.temperature_K - zero_degC_K, s.limits.current_A);
  }

  void board() {
    hal::SimSetup& b = loop().board;
    b.period_ns = 1'000'000;
    b.converter = converter(device().drive.kind == DriveKind::voltage);
    b.geometry = loop().plant.wire.wire.geometry;
    const double load_gain = 1 + dice_.uniform(-0.02, 0.02);
    b.sensors = sensors(b.geometry, load_gain, 1 + dice_.uniform(-0.005, 0.005));
    b.reads_supply = true;
    b.reads_ambient = dice_.coin();
    b.reads_driver = false;
    b.seed = dice_.seed();
    load();
  }

  void load() {
    hal::SimSetup& b = loop().board;
    low_Pa_ = high_Pa_ = MPa * dice_.uniform(10, 250);
    switch (choice(3)) {
      case 0:
        low_Pa_ = MPa * dice_.uniform(20, 150);
        high_Pa_ = low_Pa_ + MPa * dice_.uniform(20, 150);
        b.load = hal::SpringLoad{low_Pa_, high_Pa_, 0.04, 0.02};
        note("spring {:.0f} to {:.0f} MPa", low_Pa_ / MPa, high_Pa_ / MPa);
        break;
      case 1: {
        const double amplitude_Pa = dice_.uniform(0, 0.3) * low_Pa_;
        b.load = hal::VaryingLoad{low_Pa_, amplitude_Pa, log_uniform(0.3, 10), 0.02 * low_Pa_,
                                  0.5 * low_Pa_};
        note("{:.0f} MPa varying by {:.0f}", low_Pa_ / MPa, amplitude_Pa / MPa);
        break;
      }
      default:
        b.load = hal::ConstantLoad{low_Pa_};
        note("{:.0f} MPa", low_Pa_ / MPa);
    }
  }

  bench::SimEvent& event(double at_s, double for_s) {
    bench::SimEvent& e = loop().events.emplace_back();
    e.at_s = at_s;
    e.for_s = for_s;
    return e;
  }

  RandomAir draw_air() {
    constexpr std::array<std::pair<double, RandomAir>, random_air_count> shares{
        {{0.22, RandomAir::still},
         {0.10, RandomAir::draught},
         {0.13, RandomAir::gusts},
         {0.07, RandomAir::shielded},
         {0.10, RandomAir::ambient_step},
         {0.07, RandomAir::weak},
         {0.08, RandomAir::lost},
         {0.07, RandomAir::fading},
         {0.07, RandomAir::fan},
         {0.04, RandomAir::touched},
         {0.05, RandomAir::wall}}};
    double left = dice_.uniform(0, 1);
    for (const auto& [share, air] : shares) {
      left -= share;
      if (left < 0) {
        return air;
      }
    }
    return RandomAir::still;
  }

  void air() {
    hal::SimSurroundings& around = loop().board.surroundings;
    around.ambient_K = zero_degC_K + dice_.uniform(5, 40);
    note("air {:.0f} °C", around.ambient_K - zero_degC_K);
    switch (result_.air) {
      case RandomAir::still:
        break;
      case RandomAir::draught:
        around.draught = log_uniform(1, 3);
        note("draught {:.2f}", around.draught);
        break;
      case RandomAir::gusts:
        gusts();
        break;
      case RandomAir::shielded: {
        const double from_s = chance(0.3) ? 0 : dice_.uniform(1, 10);
        cools(dice_.uniform(0.75, 1), from_s, dice_.uniform(2, duration_s_));
        break;
      }
      case RandomAir::ambient_step: {
        bench::SimEvent& e = event(dice_.uniform(1, 12), dice_.uniform(2, duration_s_));
        e.ambient_K = zero_degC_K + dice_.uniform(5, 40);
        note("air {:.0f} °C from {:.1f} s for {:.1f} s", *e.ambient_K - zero_degC_K, e.at_s,
             e.for_s);
        break;
      }
      case RandomAir::weak:
        around.draught = dice_.uniform(0.3, 1);
        note("cooling {:.2f}", around.draught);
        break;
      case RandomAir::lost: {
        const double from_s = dice_.uniform(1, 0.8 * duration_s_);
        cools(dice_.uniform(0.3, 0.9), from_s, chance(0.5) ? duration_s_ : log_uniform(0.5, 20));
        break;
      }
      case RandomAir::fading:
        fading();
        break;
      case RandomAir::fan:
        fan();
        break;
      case RandomAir::touched: {
        double at_s = dice_.uniform(1, 6);
        for (std::size_t i = 1 + choice(3); i > 0; --i) {
          const double for_s = log_uniform(0.1, 3);
          cools(log_uniform(2, 10), at_s, for_s);
          at_s += for_s + log_uniform(0.5, 10);
        }
        break;
      }
      case RandomAir::wall:
        wall();
        break;
    }
  }

  /// The draught at a time: that of the last event that sets one then, as bench::SimEvents has it.
  double draught_at(double time_s) {
    double draught = loop().board.surroundings.draught;
    for (const bench::SimEvent& e : loop().events) {
      if (e.draught && e.holds(time_s)) {
        draught = *e.draught;
      }
    }
    return draught;
  }

  void find_halving() {
    constexpr double within_s = 1;
    std::vector<double> edges_s{0};
    for (const bench::SimEvent& e : loop().events) {
      if (e.draught) {
        edges_s.insert(edges_s.end(), {e.at_s, e.at_s + e.for_s});
      }
    }
    std::ranges::sort(edges_s);
    result_.halved_s = std::numeric_limits<double>::infinity();
    for (const double edge_s : edges_s) {
      double most = draught_at(std::max(0.0, edge_s - within_s));
      for (const double before_s : edges_s) {
        most = edge_s - within_s < before_s && before_s < edge_s
                   ? std::max(most, draught_at(before_s))
                   : most;
      }
      if (2 * draught_at(edge_s) <= most) {
        result_.halved_s = edge_s;
        return;
      }
    }
  }

  void cools(double draught, double at_s, double for_s) {
    bench::SimEvent& e = event(at_s, for_s);
    e.draught = draught;
    note("cooling {:.2f} from {:.1f} s for {:.1f} s", draught, at_s, for_s);
  }

  void gusts() {
    double at_s = chance(0.3) ? 0 : dice_.uniform(1, 6);
    for (std::size_t i = 1 + choice(3); i > 0; --i) {
      const double for_s = log_uniform(0.3, 8);
      cools(log_uniform(1.2, 3), at_s, for_s);
      at_s += for_s + log_uniform(0.2, 4);
    }
  }

  /// The cooling falls in small steps over some seconds, as when a cover slides over the wire.
  void fading() {
    constexpr int steps = 20;
    const double to = dice_.uniform(0.3, 0.9);
    const double from_s = dice_.uniform(1, 0.5 * duration_s_);
    const double within_s = log_uniform(0.5, 20);
    for (int i = 1; i <= steps; ++i) {
      const double share = static_cast<double>(i) / steps;
      event(from_s + within_s * share, i < steps ? within_s / steps : duration_s_).draught =
          1 + share * (to - 1);
    }
    note("cooling falls to {:.2f} from {:.1f} s within {:.1f} s", to, from_s, within_s);
  }

  /// The wire was calibrated in the draught of a fan, which fails once or several times; it may be
  /// off from the start.
  void fan() {
    loop().board.surroundings.draught = fan_;
    note("fan {:.2f}", fan_);
    double at_s = chance(0.3) ? 0 : dice_.uniform(1, 0.5 * duration_s_);
    for (std::size_t i = 1 + choice(3); i > 0; --i) {
      const double for_s = chance(0.4) ? duration_s_ : log_uniform(0.5, 20);
      cools(1, at_s, for_s);
      at_s += for_s + log_uniform(0.5, 10);
    }
  }

  /// The wire is close to a wall or to other wires, which enclose the air; the wire warms this air.
  void wall() {
    constexpr int steps = 12;
    hal::SimSurroundings& around = loop().board.surroundings;
    around.draught = dice_.uniform(0.5, 0.9);
    loop().board.reads_ambient = false;
    const double by_K = dice_.uniform(0, 15);
    const double within_s = log_uniform(5, 100);
    for (int i = 1; i <= steps; ++i) {
      const double share = static_cast<double>(i) / steps;
      event(within_s * share, i < steps ? within_s / steps : 1000).ambient_K =
          around.ambient_K + share * by_K;
    }
    note("cooling {:.2f}, air {:.0f} K warmer within {:.0f} s", around.draught, by_K, within_s);
  }

  /// No trouble in 40 % of the scenarios; two at once in a quarter of the others.
  void trouble() {
    result_.trouble = result_.second = RandomTrouble::none;
    if (chance(0.4)) {
      return;
    }
    result_.trouble = one_trouble();
    if (chance(0.25)) {
      result_.second = one_trouble();
    }
  }

  RandomTrouble one_trouble() {
    const auto trouble = static_cast<RandomTrouble>(1 + choice(random_trouble_count - 1));
    spoil(trouble);
    return trouble;
  }

  void spoil(RandomTrouble trouble) {
    const double at_s = dice_.uniform(1, 0.7 * duration_s_);
    const double for_s = chance(0.5) ? duration_s_ : log_uniform(0.02, 5);
    bench::SimEvent& e = event(at_s, for_s);
    note("{} from {:.2f} s for {:.2f} s", random_trouble_name(trouble), at_s, for_s);
    switch (trouble) {
      case RandomTrouble::load_change:
        e.added_stress_Pa = dice_.uniform(-0.6, 0.6) * low_Pa_;
        note("{:+.0f} MPa", *e.added_stress_Pa / MPa);
        break;
      case RandomTrouble::load_lost:
        e.added_stress_Pa = -low_Pa_;
        break;
      case RandomTrouble::stuck:
      case RandomTrouble::offset:
      case RandomTrouble::noise:
      case RandomTrouble::gain:
      case RandomTrouble::missing:
        sensor(e, trouble);
        break;
      case RandomTrouble::lost_frames:
        e.lost_share = chance(0.3) ? 1 : dice_.uniform(0.02, 0.8);
        note("{:.2f}", e.lost_share);
        break;
      case RandomTrouble::weak_supply:
        e.supply_V = dice_.uniform(0.5, 12);
        note("{:.1f} V", *e.supply_V);
        break;
      case RandomTrouble::weak_converter:
        // The converter is weak during the whole run, so this trouble is no event.
        loop().events.pop_back();
        loop().board.converter.max_A = dice_.uniform(0.05, 0.3);
        loop().board.converter.slew_A_s = log_uniform(2, 200);
        note("{:.2f} A, {:.0f} A/s", loop().board.converter.max_A, loop().board.converter.slew_A_s);
        break;
      case RandomTrouble::broken:
        e.circuit = dice_.coin() ? hal::Circuit::broken : hal::Circuit::open;
        break;
      case RandomTrouble::shorted:
        e.circuit = hal::Circuit::shorted;
        e.bridged_share = dice_.uniform(0.1, 0.95);
        note("{:.0f} %", 100 * e.bridged_share);
        break;
      case RandomTrouble::slip:
        e.slip = dice_.uniform(0.002, 0.03);
        break;
      case RandomTrouble::reboot:
        e.for_s = log_uniform(0.005, 2);
        e.reboots = true;
        note("{:.3f} s", e.for_s);
        break;
      case RandomTrouble::none:
        break;
    }
  }

  void sensor(bench::SimEvent& e, RandomTrouble trouble) {
    const std::size_t which = choice(sensor_names.size());
    hal::SpoiltSensor spoilt;
    double amount = 0;
    switch (trouble) {
      case RandomTrouble::stuck:
        spoilt = {hal::SensorFault::stuck, 0};
        break;
      case RandomTrouble::offset:
        spoilt = {hal::SensorFault::offset, 0};
        amount =
            sign() *
            std::array{log_uniform(0.5e-3, 50e-3), log_uniform(0.01, 3), log_uniform(0.02, 1)}.at(
                which);
        break;
      case RandomTrouble::noise:
        spoilt = {hal::SensorFault::noise, 0};
        amount =
            std::array{log_uniform(0.05e-3, 5e-3), log_uniform(1e-3, 0.1), log_uniform(0.01, 0.2)}
                .at(which);
        break;
      case RandomTrouble::gain:
        spoilt = {hal::SensorFault::gain, 0};
        amount = dice_.uniform(0.5, 1.5);
        break;
      default:
        spoilt = {hal::SensorFault::missing, 0};
    }
    spoilt.amount = amount;
    e.sensor = {static_cast<hal::Reading>(which), spoilt};
    note("{} {:.4g}", sensor_names.at(which), amount);
  }

  // Set-points.

  /// The power that holds the wire at its limit in still air.
  double limit_W() {
    return plant_params(known_).body.loss_W(device().limits.temperature_K -
                                            device().limits.hot_spot_K - room_K);
  }
  double setpoint(Mode mode) {
    const bool beyond = result_.beyond;
    const double ohm = cold_resistance_ohm(known_);
    const double share = beyond ? dice_.uniform(-0.6, 1.4) : dice_.uniform(0.1, 0.9);
    const double strain = smaservo::strain(known_.material, Phases<double>{0, 0}, high_Pa_) +
                          share * known_.nominal_stroke;
    switch (mode) {
      case Mode::current:
        return std::sqrt(limit_W() / ohm) * dice_.uniform(0, beyond ? 3 : 0.9);
      case Mode::power:
        return limit_W() * dice_.uniform(0, beyond ? 6 : 0.8);
      case Mode::resistance:
        return ohm * (beyond ? dice_.uniform(0.5, 1.4) : dice_.uniform(0.9, 1));
      case Mode::temperature:
        return beyond
                   ? device().limits.temperature_K + dice_.uniform(-20, 80)
                   : dice_.uniform(320, device().limits.temperature_K - device().limits.hot_spot_K);
      case Mode::position:
        return (device().axis.zero_strain - strain) * known_.geometry.length_m;
      case Mode::force:
        return known_.geometry.area_m2() *
               (beyond ? dice_.uniform(0, 2) * high_Pa_ : dice_.uniform(low_Pa_, high_Pa_));
      default:
        return strain;
    }
  }

  void stretch(Mode mode, double seconds, double from, double to) {
    bench::CommandStretch s{};
    s.command.mode = mode;
    s.command.arm = mode != Mode::off;
    s.command.setpoint = from;
    s.end = to;
    s.seconds = seconds;
    loop().program.push_back(s);
    used_s_ += seconds;
  }

  void shape(Mode mode, double seconds) {
    const double level = setpoint(mode);
    const double other = setpoint(mode);
    switch (choice(4)) {
      case 0:
        stretch(mode, seconds, level, level);
        break;
      case 1: {
        const double each_s = log_uniform(0.1, 2);
        for (int i = 0; i < 5; ++i) {
          const double step = level + (other - level) * 0.25 * i;
          stretch(mode, each_s, step, step);
        }
        break;
      }
      case 2: {
        stretch(mode, seconds, 0.5 * (level + other), 0.5 * (level + other));
        bench::CommandStretch& sine = loop().program.back();
        sine.amplitude = 0.5 * std::abs(other - level);
        sine.from_Hz = sine.to_Hz = log_uniform(0.1, 5);
        break;
      }
      default:
        stretch(mode, seconds, level, other);
    }
  }

  /// Clears faults and arms the device again, like a user who wants to go on.
  void insist() {
    stretch(Mode::off, 0.05, 0, 0);
    loop().program.back().command.clear_faults = true;
    stretch(Mode::off, log_uniform(0.01, 1), 0, 0);
  }

  void commands() {
    constexpr std::array modes{Mode::strain,      Mode::position, Mode::strain,
                               Mode::temperature, Mode::power,    Mode::current,
                               Mode::resistance,  Mode::force,    Mode::identification};
    result_.mode = modes.at(choice(modes.size()));
    result_.beyond = chance(0.4);
    const bool insists = chance(0.4);
    note("{}{}{}", text::mode_name(result_.mode), result_.beyond ? " beyond" : "",
         insists ? ", insists" : "");
    stretch(Mode::off, 0.3, 0, 0);
    while (used_s_ < duration_s_) {
      const Mode mode = chance(0.85) ? result_.mode : modes.at(choice(modes.size()));
      shape(mode, log_uniform(0.5, duration_s_ < 60 ? 8 : 40));
      if (insists && chance(0.5)) {
        insist();
      }
    }
  }

  bench::Dice dice_;
  RandomScenario result_{};
  Wire<double> known_{};
  double low_Pa_ = 0, high_Pa_ = 0;
  double used_s_ = 0;
  double duration_s_ = 20;
  double fan_ = 1;  ///< convection in which the wire's file was fitted, relative to still air
};

}  // namespace

std::string_view random_air_name(RandomAir air) {
  return air_names.at(static_cast<std::size_t>(air));
}

std::string_view random_trouble_name(RandomTrouble trouble) {
  return trouble_names.at(static_cast<std::size_t>(trouble));
}

std::vector<CalibratedUnit> calibrated_units(int of_each, std::uint64_t seed,
                                             const std::string& folder) {
  std::vector<CalibratedUnit> units;
  for (int i = 0; i < of_each; ++i) {
    for (const hal::Family family : hal::tuning_families) {
      const bench::WireUnit unit = bench::random_unit(family, seed + static_cast<std::uint64_t>(i));
      units.push_back({unit, calibrated_wire(unit, folder)});
    }
  }
  return units;
}

RandomScenario random_scenario(const std::vector<CalibratedUnit>& units, std::uint64_t seed) {
  return Draw(units, seed).scenario();
}

}  // namespace smaservo::evaluate
