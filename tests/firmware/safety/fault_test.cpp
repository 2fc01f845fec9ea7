// Every fault, provoked on a simulated wire.

#include <cmath>
#include <gtest/gtest.h>

#include "tests/firmware/safety/provokers.hpp"

namespace smaservo::fault_test {
namespace {

class Provoked : public ::testing::TestWithParam<Fault> {
 protected:
  Provoked() {
    Settings<double> settings = test_settings();
    const Wire<double> wire = settings.wire;
    if (provoker_.change) {
      provoker_.change(settings);
    }
    rig_ = std::make_unique<Rig>(settings, std::make_unique<LumpedRigWire>(wire, Unlike{}, load_Pa),
                                 load_Pa);
  }

  static Provoker find(Fault fault) {
    for (const Provoker& p : provokers()) {
      if (p.fault == fault) {
        return p;
      }
    }
    return {Fault::none, {}};
  }

  /// Lets the device hold a strain, then commands a smaller one, and lets the fault's cause begin
  /// at that instant.
  void cause_while_running() {
    rig_->run(0.1);
    const double top = rig_->wire->strain();
    rig_->arm(Mode::strain, top - 0.012);
    rig_->run(0.3);
    ASSERT_EQ(rig_->out.state, DeviceState::running);
    ASSERT_TRUE(rig_->out.active.empty()) << fault_name(rig_->out.active.first());
    rig_->command.setpoint = top - 0.025;
    provoker_.cause(*rig_);
  }

  double limit_s() const {
    return provoker_.within_s + deglitch_s(GetParam(), rig_->settings) + 0.002;
  }
  /// Steps until the set contains the fault; returns the time that this took.
  double time_until(const FaultSet& set) {
    const int start = rig_->steps;
    const double longest_s = limit_s();
    do {
      rig_->step();
    } while (!set.has(GetParam()) && (rig_->steps - start) * Rig::dt_s < longest_s + 0.5);
    return (rig_->steps - start) * Rig::dt_s;
  }

  static constexpr double load_Pa = 150e6;
  Provoker provoker_ = find(GetParam());
  std::unique_ptr<Rig> rig_;
};

class TrippingFault : public Provoked {};
class BlockingFault : public Provoked {};
class MildFault : public Provoked {};

TEST_P(TrippingFault, EndsTheHeatInTime) {
  const FaultRow& row = fault_row(GetParam());
  if (comes_while_off(GetParam())) {
    rig_->run(0.2);
    provoker_.cause(*rig_);
  } else {
    ASSERT_NO_FATAL_FAILURE(cause_while_running());
  }
  const double took_s = time_until(rig_->out.latched);
  EXPECT_LE(took_s, limit_s() + 1e-9)
      << row.name << ", first " << fault_name(rig_->out.first_cause);
  EXPECT_GE(took_s, deglitch_s(GetParam(), rig_->settings) - 1e-9) << row.name;
  EXPECT_EQ(rig_->out.drive_current_A, 0);
  // The device stays off, whatever is commanded.
  rig_->command.setpoint = 0.01;
  for (int i = 0; i < 300; ++i) {
    rig_->command.arm = i % 100 < 50;
    EXPECT_EQ(rig_->step().drive_current_A, 0);
  }
  EXPECT_EQ(rig_->out.state, DeviceState::fault);
  EXPECT_LE(rig_->hottest_K, rig_->settings.trips.temperature_K + 3);
}

TEST_P(BlockingFault, KeepsTheDeviceFromArming) {
  const FaultRow& row = fault_row(GetParam());
  provoker_.cause(*rig_);
  rig_->run(std::max(0.2, provoker_.before_s) + row.deglitch_s);
  double max_A = 0;
  rig_->command.arm = true;
  rig_->command.mode = Mode::strain;
  rig_->command.setpoint = 0.02;
  for (int i = 0; i < 300; ++i) {
    max_A = std::max(max_A, rig_->step().drive_current_A);
  }
  EXPECT_TRUE(rig_->out.blocks.has(GetParam())) << row.name;
  EXPECT_EQ(rig_->out.state, DeviceState::ready);
  EXPECT_EQ(rig_->out.drive_current_A, 0);
  const bool found_by_sensing = provoker_.before_s > 0;
  EXPECT_LE(max_A, found_by_sensing ? rig_->settings.limits.min_current_A : 0);
}

TEST_P(MildFault, WarnsOrLimitsInTime) {
  const FaultRow& row = fault_row(GetParam());
  ASSERT_NO_FATAL_FAILURE(cause_while_running());
  EXPECT_LE(time_until(rig_->out.warnings), limit_s() + 1e-9) << row.name;
  EXPECT_TRUE(rig_->out.latched.empty());
  EXPECT_EQ(rig_->out.state, DeviceState::running);
  if (row.severity == FaultClass::L) {
    EXPECT_LE(rig_->out.drive_current_A, rig_->settings.limits.min_current_A);
    EXPECT_TRUE(rig_->out.limited_by(LimitReason::protection));
  }
  EXPECT_LE(rig_->hottest_K, rig_->settings.trips.temperature_K + 3);
}

TEST(Faults, EachHasOneProvoker) {
  for (const FaultRow& row : fault_rows) {
    int n = 0;
    for (const Provoker& p : provokers()) {
      n += p.fault == row.fault && p.cause ? 1 : 0;
    }
    EXPECT_EQ(n, 1) << row.name;
  }
}

/// The numbers of the faults are the bits of 2202h, and are sent in an EMCY. If this test fails
/// though no fault was added at the end, one has been inserted or moved, and clients of other
/// releases would give it a wrong name.
TEST(Faults, KeepTheirNumbers) {
  std::string names;
  for (const FaultRow& row : fault_rows) {
    names += std::string(row.name) + ' ';
  }
  EXPECT_EQ(static_cast<int>(fault_rows.front().fault), 1);
  EXPECT_EQ(names,
            "supply_low supply_high over_current current_saturated voltage_saturated "
            "current_offset current_control current_while_off driver_fault driver_warm driver_hot "
            "kelvin_mismatch wire_open wire_short sense_lead_open resistance_jump no_response "
            "over_temperature heat_limit overheat_onset overheat_signature heating_fast "
            "heating_rate load_lost over_stress over_strain slip_seen clamp_slip drift cycles "
            "cold_resistance duty model_divergence estimate_invalid estimate_unsure "
            "following_error power_balance ambient_range started_outside sensor_invalid "
            "sample_stale sample_frozen control_invalid deadline_missed command_timeout "
            "emergency_stop cooling_timeout bus_lost duplicate_node unclean_boot store_corrupt "
            "bad_configuration not_configured store_outdated cooling_weak cooling_lost "
            "loop_stalled ");
}

std::vector<Fault> all(FaultSet set) {
  std::vector<Fault> faults;
  for_each_fault(set, [&](Fault fault) { faults.push_back(fault); });
  return faults;
}
std::string test_name(const ::testing::TestParamInfo<Fault>& tested) {
  return std::string(fault_name(tested.param));
}

INSTANTIATE_TEST_SUITE_P(All, TrippingFault, ::testing::ValuesIn(all(tripping_faults)), test_name);
INSTANTIATE_TEST_SUITE_P(All, BlockingFault, ::testing::ValuesIn(all(faults_of(FaultClass::B))),
                         test_name);
INSTANTIATE_TEST_SUITE_P(All, MildFault,
                         ::testing::ValuesIn(all(faults_of(FaultClass::W) | limiting_faults)),
                         test_name);

}  // namespace
}  // namespace smaservo::fault_test
