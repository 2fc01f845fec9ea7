// FMUs as a simulator meets them: unpacked, loaded, driven through the C interface of FMI 2 and 3.

#include "tests/host-sim/fmu/fmu.hpp"

#include <cmath>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <limits>
#include <map>
#include <random>
#include <sstream>

#include "firmware/text/device_names.hpp"
#include "firmware/text/settings_file.hpp"
#include "host-sim/fmu/unit/servo_variables.hpp"
#include "model/files/wire/wire_file.hpp"
#include "model/wire/wire_plant.hpp"
#include "tests/host-sim/program.hpp"

namespace smaservo::test {
namespace {

using fmu::Version;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::StartsWith;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
const std::string wire_name{"smartflex-76um"};

fmu::ExportOptions wire_of(Version version) {
  fmu::ExportOptions options;
  options.kind = fmu::Kind::wire;
  options.version = version;
  options.wire = wire_name;
  return options;
}

fmu::ExportOptions servo_of(Version version) {
  fmu::ExportOptions options = wire_of(version);
  options.kind = fmu::Kind::servo;
  return options;
}

/// Each of the two kinds in each of the two versions.
struct Case {
  fmu::Kind kind;
  Version version;
};
void PrintTo(const Case& one, std::ostream* out) {
  *out << (one.kind == fmu::Kind::wire ? "wire" : "servo")
       << (one.version == Version::fmi2 ? "2" : "3");
}

class Fmu : public ::testing::TestWithParam<Case> {
 protected:
  static const FmuFolder& fmu(Case which) {
    static std::map<std::pair<fmu::Kind, Version>, std::unique_ptr<FmuFolder>> all;
    std::unique_ptr<FmuFolder>& one = all[{which.kind, which.version}];
    if (!one) {
      one = std::make_unique<FmuFolder>(which.kind == fmu::Kind::wire ? wire_of(which.version)
                                                                      : servo_of(which.version));
    }
    return *one;
  }
  static const FmuFolder& fmu() { return fmu(GetParam()); }
  static bool servo() { return GetParam().kind == fmu::Kind::servo; }
};

INSTANTIATE_TEST_SUITE_P(Both, Fmu,
                         ::testing::Values(Case{fmu::Kind::wire, Version::fmi2},
                                           Case{fmu::Kind::wire, Version::fmi3},
                                           Case{fmu::Kind::servo, Version::fmi2},
                                           Case{fmu::Kind::servo, Version::fmi3}),
                         [](const auto& one) { return ::testing::PrintToString(one.param); });

/// A course of inputs that is random and the same for each seed.
class Course {
 public:
  explicit Course(unsigned seed) : random_(seed) {}

  double between(double low, double high) {
    return low + (high - low) * static_cast<double>(random_()) / 4294967295.0;
  }
  /// Sets some inputs anew.
  void act(Slave& slave, bool servo) {
    if (servo) {
      if (between(0, 1) < 0.02) {
        EXPECT_EQ(slave.set("mode", between(0, 1) < 0.2 ? 0 : 5), "");
        EXPECT_EQ(slave.set("setpoint", between(0.005, 0.038)), "");
      }
      EXPECT_EQ(slave.set("enable", 1), "");
    } else {
      EXPECT_EQ(slave.set("current_A", between(0, 0.2)), "");
    }
    EXPECT_EQ(slave.set("load_N", between(0.3, 0.6)), "");
    EXPECT_EQ(slave.set("ambient_K", between(290, 305)), "");
    EXPECT_EQ(slave.set("draught", between(0.8, 1.5)), "");
  }

 private:
  std::mt19937 random_;
};

bool same(const std::vector<double>& a, const std::vector<double>& b) {
  return a.size() == b.size() && std::equal(a.begin(), a.end(), b.begin(), [](double x, double y) {
           return x == y || (x != x && y != y);
         });
}

// --- equal to what they are made of
// ---------------------------------------------------------------

TEST(FmuOfAWire, EqualsThePlantToTheBit) {
  for (const Version version : {Version::fmi2, Version::fmi3}) {
    const FmuFolder unpacked(wire_of(version));
    Slave slave(unpacked);
    ASSERT_NE(slave.it, nullptr);
    const Wire<double> wire = files::load_wire(wire_name).wire;
    WirePlant<double> plant(wire, 0.4, 300);
    EXPECT_EQ(slave.set("load_N", 0.4), "");
    EXPECT_EQ(slave.set("ambient_K", 300), "");
    EXPECT_EQ(slave.begin(), "");
    EXPECT_EQ(slave.get("strain"), plant.output().strain);
    Course course(7);
    double least = 1;
    for (int i = 0; i < 3000; ++i) {
      const WireInput<double> in{.current_A = course.between(0, 0.2),
                                 .load_N = course.between(0.2, 0.6),
                                 .ambient_K = course.between(280, 310),
                                 .draught = course.between(0.5, 2)};
      EXPECT_EQ(slave.set("current_A", in.current_A), "");
      EXPECT_EQ(slave.set("load_N", in.load_N), "");
      EXPECT_EQ(slave.set("ambient_K", in.ambient_K), "");
      EXPECT_EQ(slave.set("draught", in.draught), "");
      const double step_s = course.between(1e-5, 0.03);
      ASSERT_EQ(slave.step(step_s), "");
      const WireOutput<double> out = plant.update(in, step_s);
      ASSERT_EQ(slave.get("strain"), out.strain);
      ASSERT_EQ(slave.get("displacement_m"), out.strain * wire.geometry.length_m);
      ASSERT_EQ(slave.get("resistance_ohm"), out.resistance_ohm);
      ASSERT_EQ(slave.get("temperature_K"), out.temperature_K);
      ASSERT_EQ(slave.get("martensite"), out.martensite);
      ASSERT_EQ(slave.get("r_phase"), out.r_phase);
      ASSERT_EQ(slave.get("voltage_V"), in.current_A * out.resistance_ohm);
      ASSERT_EQ(slave.get("power_W"), in.current_A * in.current_A * out.resistance_ohm);
      least = std::min(least, out.strain);
    }
    EXPECT_LT(least, 0.015) << "the wire never contracted";
  }
}

TEST(FmuOfAWire, ALongStepIsDividedAsThePlantDividesIt) {
  const FmuFolder unpacked(wire_of(Version::fmi3));
  Slave slave(unpacked);
  EXPECT_EQ(slave.set("current_A", 0.05), "");
  EXPECT_EQ(slave.begin(), "");
  const Wire<double> wire = files::load_wire(wire_name).wire;
  WirePlant<double> plant(wire, slave.get("load_N"), slave.get("ambient_K"));
  EXPECT_EQ(slave.step(150), "");
  WireOutput<double> out{};
  for (int i = 0; i < 3; ++i) {
    out = plant.update({.current_A = 0.05, .load_N = slave.get("load_N")}, 50);
  }
  EXPECT_EQ(slave.get("temperature_K"), out.temperature_K);
}

/// A trace by name of column.
class LoopTrace {
 public:
  explicit LoopTrace(const std::string& text) {
    std::istringstream lines(text);
    std::string line;
    while (std::getline(lines, line)) {
      if (line.starts_with('#')) {
        continue;
      }
      std::vector<std::string> cells;
      std::istringstream row(line);
      for (std::string cell; std::getline(row, cell, ',');) {
        cells.push_back(cell);
      }
      if (names_.empty()) {
        names_ = cells;
      } else {
        rows_.push_back(cells);
      }
    }
  }
  std::size_t size() const { return rows_.size(); }
  const std::string& text(std::size_t row, const char* name) const {
    const auto at = std::ranges::find(names_, name);
    if (at == names_.end()) {
      throw std::runtime_error(std::string("no column ") + name);
    }
    return rows_.at(row).at(static_cast<std::size_t>(at - names_.begin()));
  }
  double number(std::size_t row, const char* name) const { return std::stod(text(row, name)); }

 private:
  std::vector<std::string> names_;
  std::vector<std::vector<std::string>> rows_;
};

/// A stress near 100 MPa whose force gives the same stress to the bit; the interface has forces.
double exact_stress_Pa() {
  const double area_m2 = files::load_wire(wire_name).wire.geometry.area_m2();
  double stress_Pa = 100e6;
  while (stress_Pa * area_m2 / area_m2 != stress_Pa) {
    stress_Pa += 1000;
  }
  return stress_Pa;
}

constexpr const char* scenario = R"(note = "of the FMU"
seed = 5

[device]
settings = "device.toml"

[plant]
family = "lumped"
wire = "smartflex-76um"

[load]
type = "constant"
stress_MPa = {}

[[command]]
mode = "off"
for_s = 0.4

[[command]]
shape = "random"
strain_percent = [0.8, 3.2]
each_s = [0.3, 0.9]
for_s = 4

[[command]]
current_mA = [30, 60]
for_s = 0.5

[[command]]
mode = "off"
for_s = 0.3
)";

struct Simulated {
  Program program;
  double stress_Pa = exact_stress_Pa();
  std::string settings;
  std::string trace;

  /// `changes`: lines of the settings file.
  explicit Simulated(const std::string& changes) {
    settings = program.folder().write("device.toml",
                                      changes + "[wire]\nbased_on = \"" + wire_name + "\"\n");
    program.folder().write(
        "loop.toml", fmt::format(fmt::runtime(scenario), fmt::format("{}", 1e-6 * stress_Pa)));
    const Finished f = program.run({"simulate", "loop.toml", "--out", "loop.csv"});
    EXPECT_EQ(f.status, 0) << f.err;
    trace = file_text(program.folder() / "loop.csv");
  }
};

constexpr const char* bold_settings = R"([limits]
current_mA = 300
power_W = 10
stress_MPa = 300
[trips]
current_mA = 450
stress_MPa = 400
min_strain = -0.005
max_strain = 0.07
)";

/// A trace's cycle k has the truth at k periods, which the FMU shows after the step before it.
void expect_simulated(const Simulated& simulated, double period_s, Version version) {
  fmu::ExportOptions options = servo_of(version);
  options.settings = simulated.settings;
  const double area_m2 = files::load_wire(wire_name).wire.geometry.area_m2();
  options.load_N = simulated.stress_Pa * area_m2;
  const FmuFolder unpacked(options);
  Slave slave(unpacked);
  ASSERT_NE(slave.it, nullptr);
  ASSERT_EQ(slave.set("sensors.seed", 5), "");
  ASSERT_EQ(slave.begin(), "");
  const LoopTrace trace(simulated.trace);
  ASSERT_GT(trace.size(), 1000U);
  double least = 1;
  for (std::size_t i = 0; i < trace.size(); ++i) {
    ASSERT_EQ(slave.get("strain"), trace.number(i, "strain_ref")) << i;
    ASSERT_EQ(slave.get("temperature_K"), trace.number(i, "hottest_K")) << i;
    ASSERT_EQ(slave.get("current_A"), trace.number(i, "true_current_A")) << i;
    const auto* const mode =
        std::ranges::find(fmu::unit::mode_choices, trace.text(i, "command_mode"));
    ASSERT_EQ(slave.set("mode", static_cast<double>(mode - fmu::unit::mode_choices.begin())), "");
    ASSERT_EQ(slave.set("setpoint", trace.number(i, "command_setpoint")), "");
    ASSERT_EQ(slave.set("enable", trace.number(i, "command_arm")), "");
    ASSERT_EQ(slave.step(period_s), "");
    for (const auto& [column, variable] : {std::pair{"drive_current_A", "drive_current_A"},
                                           {"strain", "estimate.strain"},
                                           {"strain_sd", "estimate.strain_sd"},
                                           {"wire_temperature_K", "estimate.temperature_K"},
                                           {"estimated_ambient_K", "estimate.ambient_K"},
                                           {"hot_spot_K", "hot_spot_K"},
                                           {"setpoint", "setpoint_in_force"},
                                           {"reference", "reference"},
                                           {"wanted_power_W", "wanted_power_W"}}) {
      ASSERT_EQ(slave.get(variable), trace.number(i, column)) << i << ' ' << column;
    }
    const auto state = static_cast<std::size_t>(slave.get("state"));
    ASSERT_EQ(fmu::unit::state_choices.at(state), trace.text(i, "state")) << i;
    ASSERT_EQ(slave.get("cycles"), static_cast<double>(i + 1));
    least = std::min(least, slave.get("strain"));
  }
  EXPECT_LT(least, 0.02) << "the servo never moved";
}

TEST(FmuOfAServo, EqualsSimulateToTheLastDigit) {
  const Simulated simulated(bold_settings);
  for (const Version version : {Version::fmi2, Version::fmi3}) {
    expect_simulated(simulated, 1e-3, version);
  }
}

TEST(FmuOfAServo, EqualsSimulateWithALongPeriodAndAVoltageDrive) {
  const Simulated simulated(
      std::string("[timing]\nperiod_ms = 2.5\n[drive]\nkind = \"voltage\"\n") + bold_settings);
  expect_simulated(simulated, 2.5e-3, Version::fmi2);
}

TEST(FmuOfAWire, EqualsTheWireOfSimulateToTheLastDigit) {
  const Simulated simulated(bold_settings);
  const LoopTrace trace(simulated.trace);
  fmu::ExportOptions options = wire_of(Version::fmi2);
  options.load_N = simulated.stress_Pa * files::load_wire(wire_name).wire.geometry.area_m2();
  const FmuFolder unpacked(options);
  Slave slave(unpacked);
  ASSERT_EQ(slave.begin(), "");
  for (std::size_t i = 1; i < trace.size(); ++i) {
    ASSERT_EQ(slave.set("current_A", trace.number(i, "true_current_A")), "");
    ASSERT_EQ(slave.step(1e-3), "");
    ASSERT_EQ(slave.get("strain"), trace.number(i, "strain_ref")) << i;
    ASSERT_EQ(slave.get("temperature_K"), trace.number(i, "hottest_K")) << i;
  }
}

TEST(FmuOfAServo, TheNamesOfItsChoicesAreThoseOfTheDevice) {
  for (std::size_t i = 0; i < fmu::unit::mode_choices.size(); ++i) {
    EXPECT_EQ(fmu::unit::mode_choices.at(i), text::mode_name(static_cast<Mode>(i)));
  }
  for (std::size_t i = 0; i < fmu::unit::state_choices.size(); ++i) {
    EXPECT_EQ(fmu::unit::state_choices.at(i), text::state_name(static_cast<DeviceState>(i)));
  }
}

// --- steps
// ----------------------------------------------------------------------------------------

TEST(FmuOfAServo, StepsOfWholeMillisecondsGiveTheSameBits) {
  const FmuFolder unpacked(servo_of(Version::fmi3));
  Slave one(unpacked);
  Slave other(unpacked);
  for (Slave* slave : {&one, &other}) {
    ASSERT_EQ(slave->set("mode", 5), "");
    ASSERT_EQ(slave->set("setpoint", 0.035), "");
    ASSERT_EQ(slave->begin(), "");
  }
  std::mt19937 random(3);
  for (int i = 0; i < 100; ++i) {
    const int milliseconds = 1 + static_cast<int>(random() % 40);
    for (int k = 0; k < milliseconds; ++k) {
      ASSERT_EQ(one.step(1e-3), "");
    }
    // The time by which a simulator has gone on is never exactly that of the other.
    ASSERT_EQ(other.step_from(other.time_s, 1e-3 * milliseconds), "");
    other.time_s += 1e-3 * milliseconds;
    std::vector<double> a = one.all();
    std::vector<double> b = other.all();
    EXPECT_NEAR(a[0], b[0], 1e-9);
    a[0] = b[0];
    ASSERT_TRUE(same(a, b)) << i;
  }
  EXPECT_EQ(one.get("state"), 3);
}

TEST(FmuOfAServo, AnyStepGivesEachCycleItsTime) {
  const FmuFolder unpacked(servo_of(Version::fmi2));
  Slave one(unpacked);
  Slave other(unpacked);
  for (Slave* slave : {&one, &other}) {
    ASSERT_EQ(slave->set("mode", 5), "");
    ASSERT_EQ(slave->set("setpoint", 0.035), "");
    for (const char* noise :
         {"sensors.current_noise_A", "sensors.voltage_noise_V", "sensors.load_noise_N"}) {
      ASSERT_EQ(slave->set(noise, 0), "");
    }
    ASSERT_EQ(slave->begin(), "");
  }
  Course course(4);
  for (int i = 0; i < 4000; ++i) {
    ASSERT_EQ(other.step(i % 3 == 0 ? 1e-3 : course.between(1e-6, 2.7e-3)), "");
    // Cycles are at 0, 1, 2, ... ms, each before the time of the step's end.
    ASSERT_EQ(other.get("cycles"), std::ceil(std::round(other.time_s * 1e9) * 1e-6 - 1e-9));
  }
  while (one.time_s < other.time_s - 1e-3) {
    ASSERT_EQ(one.step(1e-3), "");
  }
  ASSERT_EQ(one.step(other.time_s - one.time_s), "");
  EXPECT_NEAR(one.get("strain"), other.get("strain"), 2e-5);
  EXPECT_NEAR(one.get("temperature_K"), other.get("temperature_K"), 0.1);
  EXPECT_EQ(one.get("state"), 3);
  EXPECT_EQ(other.get("state"), 3);
}

TEST_P(Fmu, StartsAtAnyTime) {
  Slave one(fmu());
  Slave other(fmu());
  ASSERT_EQ(one.begin(), "");
  ASSERT_EQ(other.begin(-12.5), "");
  Course a(1);
  Course b(1);
  for (int i = 0; i < 100; ++i) {
    a.act(one, servo());
    b.act(other, servo());
    ASSERT_EQ(one.step(0.0078125), "");
    ASSERT_EQ(other.step(0.0078125), "");
  }
  std::vector<double> of_one = one.all();
  std::vector<double> of_other = other.all();
  EXPECT_EQ(of_other[0], of_one[0] - 12.5);
  of_other[0] = of_one[0];
  EXPECT_TRUE(same(of_one, of_other));
}

// --- states
// ---------------------------------------------------------------------------------------

TEST_P(Fmu, GoesOnFromASavedState) {
  Slave slave(fmu());
  Slave other(fmu());
  ASSERT_EQ(slave.begin(), "");
  Course course(11);
  for (int part = 0; part < 12; ++part) {
    for (int i = 0; i < 60; ++i) {
      course.act(slave, servo());
      ASSERT_EQ(slave.step(course.between(1e-4, 4e-3)), "");
    }
    void* state = nullptr;
    ASSERT_EQ(slave.save(state), "");
    const double then_s = slave.time_s;
    const std::vector<double> then = slave.all();
    const std::vector<unsigned char> bytes = slave.serialized(state);
    const Course before = course;
    for (int i = 0; i < 60; ++i) {
      course.act(slave, servo());
      ASSERT_EQ(slave.step(course.between(1e-4, 4e-3)), "");
    }
    const std::vector<double> end = slave.all();
    ASSERT_FALSE(same(then, end));
    // Back in the same instance.
    ASSERT_EQ(slave.restore(state), "");
    ASSERT_TRUE(same(slave.all(), then));
    Course again = before;
    slave.time_s = then_s;
    for (int i = 0; i < 60; ++i) {
      again.act(slave, servo());
      ASSERT_EQ(slave.step(again.between(1e-4, 4e-3)), "");
    }
    ASSERT_TRUE(same(slave.all(), end));
    // From the bytes in another one, which was only instantiated.
    void* read = nullptr;
    ASSERT_EQ(other.deserialize(bytes, read), "");
    ASSERT_EQ(other.restore(read), "");
    ASSERT_TRUE(same(other.all(), then));
    again = before;
    other.time_s = then_s;
    for (int i = 0; i < 60; ++i) {
      again.act(other, servo());
      ASSERT_EQ(other.step(again.between(1e-4, 4e-3)), "");
    }
    ASSERT_TRUE(same(other.all(), end));
    // A state is written over one that is there.
    ASSERT_EQ(slave.save(state), "");
    ASSERT_EQ(slave.free(state), "");
    EXPECT_EQ(state, nullptr);
    ASSERT_EQ(other.free(read), "");
    ASSERT_EQ(other.reset(), "");
  }
}

TEST_P(Fmu, ASavedStateHasTheParameters) {
  Slave slave(fmu());
  const char* const length = "wire.length_m";
  const double start_m = slave.get(length);
  ASSERT_EQ(slave.set(length, 0.125), "");
  ASSERT_EQ(slave.begin(), "");
  ASSERT_EQ(slave.step(0.01), "");
  void* state = nullptr;
  ASSERT_EQ(slave.save(state), "");
  ASSERT_EQ(slave.step(0.01), "");
  const std::vector<double> end = slave.all();
  ASSERT_EQ(slave.reset(), "");
  EXPECT_EQ(slave.get(length), start_m);
  ASSERT_EQ(slave.restore(state), "");
  ASSERT_EQ(slave.step_from(0.01, 0.01), "");
  EXPECT_TRUE(same(slave.all(), end));
  EXPECT_EQ(slave.free(state), "");
}

TEST_P(Fmu, RefusesWhatIsNoStateOfIts) {
  Slave slave(fmu());
  ASSERT_EQ(slave.begin(), "");
  ASSERT_EQ(slave.step(0.01), "");
  void* state = nullptr;
  ASSERT_EQ(slave.save(state), "");
  const std::vector<unsigned char> bytes = slave.serialized(state);
  const std::vector<double> now = slave.all();
  void* read = nullptr;
  for (std::size_t size = 1; size < bytes.size(); size += 1 + size / 3) {
    EXPECT_THAT(slave.deserialize({bytes.begin(), bytes.begin() + static_cast<int>(size)}, read),
                ::testing::AnyOf(HasSubstr("no saved state"), HasSubstr("cut off")));
  }
  for (std::size_t i = 0; i < bytes.size(); i += 1 + bytes.size() / 200) {
    std::vector<unsigned char> damaged = bytes;
    damaged[i] ^= 0x10U;
    EXPECT_NE(slave.deserialize(damaged, read), "") << i;
  }
  std::vector<unsigned char> longer = bytes;
  longer.push_back(0);
  EXPECT_THAT(slave.deserialize(longer, read), HasSubstr("bytes"));
  EXPECT_EQ(read, nullptr);
  // Of another wire.
  fmu::ExportOptions options = servo() ? servo_of(GetParam().version) : wire_of(GetParam().version);
  options.wire = "flexinol-ht-0.10mm";
  const FmuFolder unpacked(options);
  Slave other(unpacked);
  EXPECT_EQ(other.deserialize(bytes, read), "the saved state is of another FMU");
  EXPECT_EQ(other.restore(state), "the saved state is of another FMU");
  EXPECT_NE(slave.restore(nullptr), "");
  EXPECT_TRUE(same(slave.all(), now));
  EXPECT_EQ(slave.free(state), "");
}

TEST_P(Fmu, TwoInstancesDoNotDisturbEachOther) {
  const auto alone = [&](unsigned seed) {
    Slave slave(fmu());
    EXPECT_EQ(slave.begin(), "");
    Course course(seed);
    for (int i = 0; i < 300; ++i) {
      course.act(slave, servo());
      EXPECT_EQ(slave.step(2e-3), "");
    }
    return slave.all();
  };
  Slave one(fmu());
  Slave other(fmu());
  ASSERT_EQ(one.begin(), "");
  ASSERT_EQ(other.begin(), "");
  Course a(21);
  Course b(22);
  for (int i = 0; i < 300; ++i) {
    a.act(one, servo());
    b.act(other, servo());
    ASSERT_EQ(one.step(2e-3), "");
    ASSERT_EQ(other.step(2e-3), "");
  }
  EXPECT_TRUE(same(one.all(), alone(21)));
  EXPECT_TRUE(same(other.all(), alone(22)));
}

TEST_P(Fmu, AResetInstanceIsANewOne) {
  Slave slave(fmu());
  Slave fresh(fmu());
  ASSERT_EQ(slave.set("wire.length_m", 0.2), "");
  ASSERT_EQ(slave.begin(3), "");
  Course course(31);
  for (int i = 0; i < 100; ++i) {
    course.act(slave, servo());
    ASSERT_EQ(slave.step(2e-3), "");
  }
  ASSERT_EQ(slave.terminate(), "");
  ASSERT_EQ(slave.reset(), "");
  ASSERT_EQ(slave.begin(), "");
  ASSERT_EQ(fresh.begin(), "");
  ASSERT_TRUE(same(slave.all(), fresh.all()));
  Course a(32);
  Course b(32);
  for (int i = 0; i < 100; ++i) {
    a.act(slave, servo());
    b.act(fresh, servo());
    ASSERT_EQ(slave.step(2e-3), "");
    ASSERT_EQ(fresh.step(2e-3), "");
  }
  EXPECT_TRUE(same(slave.all(), fresh.all()));
}

// --- parameters
// -----------------------------------------------------------------------------------

TEST(FmuOfAWire, AParameterIsThatOfTheWireFile) {
  const FmuFolder unpacked(wire_of(Version::fmi2));
  Slave slave(unpacked);
  ASSERT_EQ(slave.set("wire.length_m", 0.25), "");
  ASSERT_EQ(slave.set("wire.material.mixture", 1), "");
  ASSERT_EQ(slave.begin(), "");
  Wire<double> wire = files::load_wire(wire_name).wire;
  wire.geometry.length_m = 0.25;
  wire.material.mixture = Mixture::parallel;
  const WirePlant<double> plant(wire, slave.get("load_N"), slave.get("ambient_K"));
  EXPECT_EQ(slave.get("resistance_ohm"), plant.output().resistance_ohm);
  EXPECT_EQ(slave.get("displacement_m"), plant.output().strain * 0.25);
}

TEST(FmuOfAWire, OutputsOfInitializationFollowFromWhatWasSet) {
  const FmuFolder unpacked(wire_of(Version::fmi3));
  Slave slave(unpacked);
  ASSERT_EQ(slave.enter(), "");
  const double before = slave.get("displacement_m");
  ASSERT_EQ(slave.set("wire.length_m", 0.2), "");
  EXPECT_NEAR(slave.get("displacement_m"), 2 * before, 1e-4);
  ASSERT_EQ(slave.exit(), "");
  EXPECT_NEAR(slave.get("displacement_m"), 2 * before, 1e-4);
}

TEST_P(Fmu, WhatTheCheckOfWiresRefusesIsRefused) {
  const struct {
    const char* name;
    double value;
    const char* message;
  } cases[] = {
      {"wire.length_m", -1, "wire.length_m = -1"},
      {"wire.m2a.start_0_K", 590, "start"},
      {"wire.m2a.curvature_0", 1000, "wire.m2a.curvature_0"},
      {"wire.a2r.curvature_1_1_Pa", 1e-6, "wire.a2r"},
      {"wire.a2m.finish_0_K", 400, "wire.a2m"},
      {"wire.heat.latent_r2a_J_kg", 9e4, "wire.heat.latent_r2a_J_kg"},
      {"wire.memory", 2, "wire.memory = 2: allowed are 0 to 1"},
  };
  for (const auto& one : cases) {
    Slave slave(fmu());
    ASSERT_EQ(slave.enter(), "");
    const double before = slave.get(one.name);
    ASSERT_EQ(slave.set(one.name, one.value), "");
    EXPECT_THAT(slave.exit(), HasSubstr(one.message)) << one.name;
    // It is still in initialization, and goes on with a value that is allowed.
    ASSERT_EQ(slave.set(one.name, before), "");
    EXPECT_EQ(slave.exit(), "") << one.name;
    EXPECT_EQ(slave.step(1e-3), "");
  }
}

TEST(FmuOfAServo, WhatTheCheckOfSettingsRefusesIsRefused) {
  const FmuFolder unpacked(servo_of(Version::fmi2));
  Slave slave(unpacked);
  ASSERT_EQ(slave.set("limits.current_A", 15), "");
  EXPECT_THAT(slave.begin(),
              AllOf(StartsWith("limits.current_A and "), HasSubstr("contradict each other")));
  ASSERT_EQ(slave.reset(), "");
  ASSERT_EQ(slave.set("true.wire.length_m", 1e9), "");
  EXPECT_THAT(slave.begin(), HasSubstr("true.wire.length_m"));
  ASSERT_EQ(slave.reset(), "");
  ASSERT_EQ(slave.set("strain.proportional_W", 1e300), "");
  EXPECT_THAT(slave.begin(), HasSubstr("strain.proportional_W"));
}

TEST(FmuOfAServo, TheTrueWireMayDifferFromTheSettings) {
  const FmuFolder unpacked(servo_of(Version::fmi3));
  Slave one(unpacked);
  Slave other(unpacked);
  ASSERT_EQ(other.set("true.wire.length_m", 0.15), "");
  ASSERT_EQ(one.begin(), "");
  ASSERT_EQ(other.begin(), "");
  EXPECT_NEAR(other.get("resistance_ohm"), 1.5 * one.get("resistance_ohm"),
              0.01 * one.get("resistance_ohm"));
  EXPECT_EQ(one.get("wire.length_m"), other.get("wire.length_m"));
}

// --- faults
// ---------------------------------------------------------------------------------------

/// A servo that runs.
void run_servo(Slave& slave) {
  ASSERT_EQ(slave.set("mode", 5), "");
  ASSERT_EQ(slave.set("setpoint", 0.036), "");
  ASSERT_EQ(slave.begin(), "");
  ASSERT_EQ(slave.step(1.5), "");
  ASSERT_EQ(slave.get("state"), 3);
  ASSERT_GT(slave.get("drive_current_A"), 0);
}

TEST(FmuOfAServo, AFailureOfASensorOrTheWireEndsTheHeat) {
  const FmuFolder unpacked(servo_of(Version::fmi2));
  for (const char* name :
       {"current_fails", "voltage_fails", "load_fails", "emergency_stop", "circuit"}) {
    Slave slave(unpacked);
    run_servo(slave);
    ASSERT_EQ(slave.set(name, 1), "");
    ASSERT_EQ(slave.step(3), "") << name;
    EXPECT_EQ(slave.get("drive_current_A"), 0) << name;
    EXPECT_NE(slave.get("first_cause"), 0) << name;
    const auto cause = static_cast<unsigned>(slave.get("first_cause"));
    const auto word = static_cast<unsigned>(
        slave.get("latched_" + std::to_string(cause / fmu::unit::faults_in_word)));
    EXPECT_TRUE((word >> cause % fmu::unit::faults_in_word & 1U) != 0) << name;
    ASSERT_EQ(slave.set(name, 0), "");
    ASSERT_EQ(slave.set("enable", 0), "");
    ASSERT_EQ(slave.step(3), "");
    ASSERT_EQ(slave.set("clear_faults", 1), "");
    ASSERT_EQ(slave.step(0.01), "");
    ASSERT_EQ(slave.set("clear_faults", 0), "");
    ASSERT_EQ(slave.set("enable", 1), "");
    ASSERT_EQ(slave.step(2), "");
    EXPECT_EQ(slave.get("state"), 3) << name << ": it does not run again";
  }
}

TEST(FmuOfAServo, WithoutEnableThereIsNoCurrent) {
  const FmuFolder unpacked(servo_of(Version::fmi3));
  Slave slave(unpacked);
  run_servo(slave);
  ASSERT_EQ(slave.set("enable", 0), "");
  ASSERT_EQ(slave.step(0.002), "");
  EXPECT_EQ(slave.get("current_A"), 0);
}

// --- mistakes
// -------------------------------------------------------------------------------------

TEST_P(Fmu, WhatIsNotFiniteIsRefusedAndChangesNothing) {
  Slave slave(fmu());
  ASSERT_EQ(slave.begin(), "");
  ASSERT_EQ(slave.step(0.01), "");
  const std::vector<double> before = slave.all();
  for (const double value :
       {nan, std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()}) {
    EXPECT_THAT(slave.set("load_N", value), HasSubstr("load_N = "));
    EXPECT_THAT(slave.set("ambient_K", value), HasSubstr("ambient_K = "));
    EXPECT_THAT(slave.step_from(slave.time_s, value), HasSubstr("the step"));
    EXPECT_THAT(slave.step_from(value, 0.01), HasSubstr("the step begins at"));
  }
  EXPECT_THAT(slave.set("draught", 0), HasSubstr("draught = 0: allowed are"));
  EXPECT_THAT(slave.set("ambient_K", -5), HasSubstr("ambient_K = -5: allowed are"));
  for (const double step_s : {0.0, -1e-3, 1e6}) {
    EXPECT_THAT(slave.step(step_s), HasSubstr("s long; allowed is more than 0"));
  }
  EXPECT_THAT(slave.step_from(5, 0.01), HasSubstr("the step begins at 5 s, the time is 0.01 s"));
  EXPECT_TRUE(same(slave.all(), before));
  // A load that no wire bears: the step is not made, nor is any part of it.
  ASSERT_EQ(slave.set("load_N", 1e300), "");
  EXPECT_THAT(slave.step(0.05), HasSubstr("no finite result"));
  ASSERT_EQ(slave.set("load_N", before[slave.reference("load_N")]), "");
  EXPECT_TRUE(same(slave.all(), before));
  EXPECT_EQ(slave.step(0.01), "");
}

TEST_P(Fmu, RefusesUnknownReferencesAndOtherTypes) {
  Slave slave(fmu());
  double value = 0;
  const std::size_t count = fmu().description.variables.size();
  for (const std::size_t reference : {count, count + 1, std::size_t{0xFFFFFFFF}}) {
    EXPECT_THAT(slave.get_reference(reference, fmu::unit::Type::real, value),
                HasSubstr("no variable with the value reference " + std::to_string(reference)));
    EXPECT_THAT(slave.set_reference(reference, fmu::unit::Type::flag, 0), HasSubstr("no variable"));
  }
  EXPECT_THAT(slave.get_reference(slave.reference("load_N"), fmu::unit::Type::whole, value),
              "load_N is a real, not an integer");
  EXPECT_THAT(slave.set_reference(slave.reference("wire.memory"), fmu::unit::Type::real, 1),
              "wire.memory is an enumeration, not a real");
  EXPECT_THAT(slave.set("strain", 0.01), "strain cannot be set");
  EXPECT_THAT(slave.set("time", 1), "time cannot be set");
}

TEST_P(Fmu, SetsAllOrNone) {
  Slave slave(fmu());
  ASSERT_EQ(slave.begin(), "");
  const unsigned references[] = {static_cast<unsigned>(slave.reference("load_N")),
                                 static_cast<unsigned>(slave.reference("ambient_K"))};
  const double values[] = {0.123, nan};
  const double before = slave.get("load_N");
  if (GetParam().version == Version::fmi2) {
    EXPECT_NE(slave.said(slave.library.function<decltype(fmi2SetReal)>("fmi2SetReal")(
                  slave.it, references, 2, values)),
              "");
  } else {
    const auto set = slave.library.function<decltype(fmi3SetFloat64)>("fmi3SetFloat64");
    EXPECT_NE(slave.said(set(slave.it, references, 2, values, 2)), "");
    EXPECT_THAT(slave.said(set(slave.it, references, 2, values, 1)),
                HasSubstr("one value for each value reference"));
  }
  EXPECT_EQ(slave.get("load_N"), before);
}

TEST_P(Fmu, RefusesCallsInTheWrongState) {
  Slave slave(fmu());
  EXPECT_EQ(slave.step(0.01), "a step is not allowed after instantiation");
  EXPECT_EQ(slave.exit(), "the end of initialization is not allowed after instantiation");
  EXPECT_EQ(slave.terminate(), "termination is not allowed after instantiation");
  ASSERT_EQ(slave.enter(), "");
  EXPECT_NE(slave.enter(), "");
  EXPECT_EQ(slave.step(0.01), "a step is not allowed in initialization mode");
  ASSERT_EQ(slave.exit(), "");
  EXPECT_EQ(slave.exit(), "the end of initialization is not allowed in step mode");
  EXPECT_NE(slave.enter(), "");
  EXPECT_EQ(slave.set("wire.length_m", 0.1),
            "wire.length_m is fixed: it may be set until initialization ends");
  ASSERT_EQ(slave.step(0.01), "");
  const double strain = slave.get("strain");
  ASSERT_EQ(slave.terminate(), "");
  EXPECT_EQ(slave.get("strain"), strain) << "values may be read at the end";
  EXPECT_EQ(slave.terminate(), "termination is not allowed after termination");
  EXPECT_EQ(slave.step(0.01), "a step is not allowed after termination");
  EXPECT_NE(slave.set("load_N", 0.1), "");
  EXPECT_EQ(slave.reset(), "");
  EXPECT_EQ(slave.enter(nan), "the start time is not finite");
  EXPECT_EQ(slave.begin(), "");
}

TEST_P(Fmu, RefusesResourcesThatAreNotItsOwn) {
  const auto why = [&](const std::string& token, const std::string& resources) {
    Slave slave(fmu(), token, resources);
    EXPECT_EQ(slave.it, nullptr);
    return slave.log.messages.empty() ? "" : slave.log.messages.back();
  };
  const std::string& good = fmu().resources();
  EXPECT_THAT(why("{other}", good), HasSubstr("the token {other} is not that of the resources"));
  EXPECT_THAT(why("", good), HasSubstr("the token"));
  EXPECT_THAT(why(fmu().token, "/nowhere/resources"),
              HasSubstr("/nowhere/resources/values.txt cannot be read"));
  EXPECT_THAT(why(fmu().token, ""), HasSubstr("no location"));
  EXPECT_THAT(why(fmu().token, "http://example.org/resources"), HasSubstr("no file"));
  EXPECT_THAT(why(fmu().token, "file://example.org/resources"), HasSubstr("another machine"));
  EXPECT_THAT(why(fmu().token, "file:///%zz"), HasSubstr("wrong escape"));
  EXPECT_THAT(why(fmu().token, "file:///%00"), HasSubstr("wrong escape"));
  EXPECT_THAT(why(fmu().token, "file:///a%"), HasSubstr("wrong escape"));
}

/// Each character that a URI has no place for as an escape.
std::string uri_of(const std::string& path) {
  std::string uri;
  for (const char letter : path) {
    uri += std::isalnum(static_cast<unsigned char>(letter)) != 0 || letter == '/'
               ? std::string(1, letter)
               : fmt::format("%{:02X}", static_cast<unsigned char>(letter));
  }
  return uri;
}

TEST_P(Fmu, FindsItsResourcesByAPathOrAUri) {
  const std::string& path = fmu().resources();
  ASSERT_THAT(path, HasSubstr(" ")) << "the test's folder needs an escape";
  for (const std::string& location :
       {path, path + "/", "file://" + uri_of(path), "file:" + uri_of(path),
        "file://localhost" + uri_of(path), "file://" + uri_of(path) + "/"}) {
    const Slave slave(fmu(), fmu().token, location);
    EXPECT_NE(slave.it, nullptr) << location;
  }
}

TEST_P(Fmu, RefusesAFileOfValuesThatIsNotWhole) {
  const std::string good = file_text(fmu().resources() + "/values.txt");
  TemporaryFolder folder;
  const auto why = [&](const std::string& text) {
    folder.write("values.txt", text);
    Slave slave(fmu(), fmu().token, folder.path().string());
    EXPECT_EQ(slave.it, nullptr) << text.substr(0, 200);
    return slave.log.messages.empty() ? "" : slave.log.messages.back();
  };
  /// With this line in the place of the one that begins so.
  const auto with = [&](const std::string& old, const std::string& now) {
    std::string text = good;
    const std::size_t at = text.find('\n' + old) + 1;
    EXPECT_NE(at, 0U) << old;
    return text.replace(at, text.find('\n', at) - at, now);
  };
  for (std::size_t size = 0; size < good.size(); size += 1 + size / 4) {
    why(good.substr(0, size));
  }
  why(good.substr(0, good.size() - 1));
  EXPECT_THAT(why(good + "further = 1\n"), HasSubstr("further is unknown"));
  EXPECT_THAT(why(good + "wire.length_m = 1\n"), HasSubstr("stands twice"));
  EXPECT_THAT(why(good + "no value\n"), HasSubstr("is not \"name = value\""));
  EXPECT_THAT(why(with("wire.length_m = ", "wire.lengths_m = 0.1")),
              HasSubstr("wire.length_m is missing"));
  for (const char* bad : {"x", "", "0.1x", "0,1", "nan", "inf", "1e999", "0.1 0.2"}) {
    EXPECT_THAT(why(with("wire.length_m = ", std::string("wire.length_m = ") + bad)),
                HasSubstr("is not a number"))
        << bad;
  }
  EXPECT_THAT(why(with("wire.length_m = ", "wire.length_m = -0.1")),
              HasSubstr("wire.length_m = -0.1: allowed are"));
  EXPECT_THAT(why("kind = tree" + good.substr(good.find('\n'))), HasSubstr("of a tree"));
  EXPECT_THAT(why(with("interface = ", "interface = 0123")), HasSubstr("16 digits"));
  std::string other = good;
  const std::size_t digit = other.find("interface = ") + 12;
  other[digit] = other[digit] == '0' ? '1' : '0';
  EXPECT_THAT(why(other), HasSubstr("another version of this library"));
  EXPECT_THAT(why(std::string(100000, 'x')), HasSubstr("cut off"));
}

TEST_P(Fmu, AnInstanceThatIsNoneIsAnError) {
  const FmuLibrary library(fmu().library());
  if (GetParam().version == Version::fmi2) {
    EXPECT_EQ(library.function<decltype(fmi2DoStep)>("fmi2DoStep")(nullptr, 0, 1, 1), fmi2Error);
    EXPECT_EQ(library.function<decltype(fmi2Reset)>("fmi2Reset")(nullptr), fmi2Error);
    EXPECT_EQ(library.function<decltype(fmi2Instantiate)>("fmi2Instantiate")(
                  nullptr, fmi2CoSimulation, nullptr, nullptr, nullptr, 0, 0),
              nullptr);
    const Slave slave(fmu());
    double time_s = -1;
    EXPECT_EQ(library.function<decltype(fmi2GetRealStatus)>("fmi2GetRealStatus")(
                  slave.it, fmi2LastSuccessfulTime, &time_s),
              fmi2OK);
    EXPECT_EQ(time_s, 0);
    fmi2Status status{};
    EXPECT_EQ(library.function<decltype(fmi2GetStatus)>("fmi2GetStatus")(slave.it, fmi2DoStepStatus,
                                                                         &status),
              fmi2Discard);
    int ended = 1;
    EXPECT_EQ(library.function<decltype(fmi2GetBooleanStatus)>("fmi2GetBooleanStatus")(
                  slave.it, fmi2Terminated, &ended),
              fmi2OK);
    EXPECT_EQ(ended, 0);
  } else {
    EXPECT_EQ(library.function<decltype(fmi3Reset)>("fmi3Reset")(nullptr), fmi3Error);
    Slave slave(fmu());
    const auto refused = [&](const char* name, auto* function, auto... arguments) {
      EXPECT_EQ(function(slave.it, arguments...), fmi3Error) << name;
      EXPECT_THAT(slave.log.messages.back(), HasSubstr("not offered")) << name;
    };
    refused("EnterEventMode", library.function<decltype(fmi3EnterEventMode)>("fmi3EnterEventMode"));
    refused("SetTime", library.function<decltype(fmi3SetTime)>("fmi3SetTime"), 0.0);
    refused("EnterStepMode", library.function<decltype(fmi3EnterStepMode)>("fmi3EnterStepMode"));
    const unsigned reference = 1;
    float value = 0;
    refused("GetFloat32", library.function<decltype(fmi3GetFloat32)>("fmi3GetFloat32"), &reference,
            std::size_t{1}, &value, std::size_t{1});
    EXPECT_EQ(library.function<decltype(fmi3GetFloat32)>("fmi3GetFloat32")(slave.it, nullptr, 0,
                                                                           nullptr, 0),
              fmi3OK);
  }
}

TEST_P(Fmu, SaysItsVersions) {
  const FmuLibrary library(fmu().library());
  EXPECT_STREQ(library.function<decltype(fmi2GetVersion)>("fmi2GetVersion")(), "2.0");
  EXPECT_STREQ(library.function<decltype(fmi3GetVersion)>("fmi3GetVersion")(), "3.0");
  EXPECT_STREQ(library.function<decltype(fmi2GetTypesPlatform)>("fmi2GetTypesPlatform")(),
               "default");
}

// --- the file
// -------------------------------------------------------------------------------------

TEST(FmuFile, IsWhatItsFolderHas) {
  for (const fmu::ExportOptions& options : {wire_of(Version::fmi2), servo_of(Version::fmi3)}) {
    const FmuFolder folder(options);
    const bool two = options.version == Version::fmi2;
    const TemporaryFolder scratch;
    const fmu::Written written =
        fmu::write_fmu(folder.description, options.version, scratch / "a.fmu");
    EXPECT_EQ(written.bytes, std::filesystem::file_size(scratch / "a.fmu"));
    const std::vector<std::string> names = unpack(scratch / "a.fmu", scratch / "a");
    EXPECT_TRUE(std::ranges::is_sorted(names));
    const std::string identifier = fmu::identifier(options.kind);
    for (const std::string& platform : written.platforms) {
      EXPECT_THAT(names, Contains("binaries/" + platform + "/" + identifier + ".so"));
    }
#ifdef __x86_64__
    EXPECT_THAT(written.platforms, Contains(two ? "linux64" : "x86_64-linux"));
    const std::string library = std::string("a/binaries/") + (two ? "linux64/" : "x86_64-linux/");
    EXPECT_TRUE(file_text(scratch / (library + identifier + ".so")) == file_text(folder.library()));
#endif
    EXPECT_TRUE(file_text(scratch / "a/resources/values.txt") ==
                file_text(folder.resources() + "/values.txt"));
    for (const char* name : {"modelDescription.xml", "documentation/index.html",
                             "documentation/licenses/license.txt", "sources/CMakeLists.txt"}) {
      EXPECT_THAT(names, Contains(name));
    }
    for (const std::string& source : folder.description.sources) {
      EXPECT_THAT(names, Contains("sources/" + source));
    }
    EXPECT_EQ(std::ranges::count(names, "sources/buildDescription.xml"), two ? 0 : 1);
    // A wire needs nothing of Eigen, so its FMU is MIT alone.
    const bool has_eigen = std::ranges::find(names, "sources/Eigen/Core") != names.end();
    EXPECT_EQ(has_eigen, options.kind == fmu::Kind::servo);
    const std::string license = file_text(scratch / "a/documentation/licenses/license.txt");
    EXPECT_THAT(license, HasSubstr("MIT License"));
    EXPECT_EQ(license.find("Mozilla") != std::string::npos, has_eigen);
  }
}

TEST(FmuFile, OfTheSameWireHasTheSameBytes) {
  const TemporaryFolder folder;
  const fmu::ExportOptions options = wire_of(Version::fmi3);
  fmu::write_fmu(fmu::describe(options), options.version, folder / "a.fmu");
  fmu::write_fmu(fmu::describe(options), options.version, folder / "b.fmu");
  EXPECT_TRUE(file_text(folder / "a.fmu") == file_text(folder / "b.fmu"));
}

TEST_P(Fmu, OfAnotherWireHasAnotherToken) {
  fmu::ExportOptions options = servo() ? servo_of(GetParam().version) : wire_of(GetParam().version);
  EXPECT_EQ(fmu::token_of(fmu::describe(options), options.version), fmu().token);
  options.overrides = {{"wire.length_mm", "101"}};
  EXPECT_NE(fmu::token_of(fmu::describe(options), options.version), fmu().token);
}

TEST_P(Fmu, EveryPresetCanBeExportedAndRun) {
  for (const std::string& preset : files::preset_names()) {
    fmu::ExportOptions options =
        servo() ? servo_of(GetParam().version) : wire_of(GetParam().version);
    options.wire = preset;
    const FmuFolder folder(options);
    Slave slave(folder);
    ASSERT_NE(slave.it, nullptr) << preset << ": " << slave.log.messages.back();
    EXPECT_EQ(slave.begin(), "") << preset;
    EXPECT_EQ(slave.step(0.1), "") << preset;
    EXPECT_TRUE(std::isfinite(slave.get("strain"))) << preset;
  }
}

}  // namespace
}  // namespace smaservo::test
