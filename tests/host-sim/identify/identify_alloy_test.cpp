// Alloys whose transitions no preset is near to: the fit begins where the runs show them. The
// measured data are of a NiTiCo wire in a bath and of a NiTi powder in a calorimeter.

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <random>

#include "host-sim/identify/fit/fit.hpp"
#include "host-sim/identify/report.hpp"
#include "host-sim/identify/runs/offset.hpp"
#include "model/files/wire/wire_file.hpp"
#include "tests/host-sim/identify/simulated_runs.hpp"
#include "tests/host-sim/replay/measured_data.hpp"

namespace smaservo::test {
namespace {

/// Baths at three stresses of the preset with all transitions moved.
std::vector<identify::Run> baths(const Wire<double>& preset, double by_K, std::mt19937_64& random) {
  const Wire<double> wire = identify::moved(preset, by_K);
  std::vector<double> temperature_K = cycle_K();
  for (double& one : temperature_K) {
    one += by_K;
  }
  std::vector<identify::Run> runs;
  for (const double stress_Pa : {20e6, 100e6, 250e6}) {
    runs.push_back(bath_run(wire, stress_Pa, random, temperature_K));
  }
  return runs;
}

TEST(FarAlloy, IsFoundWhereverItsTransitionsLie) {
  std::mt19937_64 random(11);
  const Wire<double> preset = files::load_wire("smartflex-76um").wire;
  identify::FitOptions options;
  options.variants = false;
  for (const double by_K : {-95.0, -50.0, -30.0, 30.0, 60.0}) {
    const identify::FitResult fit =
        identify::fit_wire(preset, baths(preset, by_K, random), options);
    EXPECT_NEAR(fit.moved_K, by_K, 6) << by_K;
    EXPECT_LT(identify::joint_strain_rms(fit).value_or(1), 0.003) << by_K;
    EXPECT_NEAR(fit.wire.kinetics.m2a.start_K[0], preset.kinetics.m2a.start_K[0] + by_K, 1) << by_K;
  }
}

/// A bath that turns within the transformation seems to say that it lies elsewhere.
TEST(FarAlloy, ARunOfHalfATransformationDoesNotMislead) {
  std::mt19937_64 random(13);
  std::normal_distribution<double> normal(0, 0.6);
  std::vector<double> narrow = cycle_K();
  std::erase_if(narrow, [](double T) { return T < 301 || T > 352; });
  identify::FitOptions options;
  options.variants = false;
  int misled = 0;
  for (const char* name : {"smartflex-76um", "flexinol-lt-0.15mm"}) {
    const Wire<double> preset = files::load_wire(name).wire;
    for (int i = 0; i < 3; ++i) {
      const Wire<double> wire = identify::vary_wire<double>(
          preset, {}, [&](const identify::FitParameter& p) { return p.value(normal(random)); });
      const std::vector<identify::Run> runs{bath_run(wire, 300e6, random, narrow)};
      misled += identify::transitions_offset_K(preset, runs) != 0 ? 1 : 0;
      EXPECT_EQ(identify::fit_wire(preset, runs, options).moved_K, 0) << name << " " << i;
    }
  }
  EXPECT_GT(misled, 3) << "the runs must be such that they mislead";
}

TEST(FarAlloy, WithinReachNothingIsMoved) {
  std::mt19937_64 random(12);
  const Wire<double> preset = files::load_wire("smartflex-76um").wire;
  for (const double by_K : {-15.0, 0.0, 15.0}) {
    EXPECT_EQ(identify::transitions_offset_K(preset, baths(preset, by_K, random)), 0) << by_K;
  }
  std::vector<identify::Run> joule{joule_run(preset, 100e6, random)};
  EXPECT_EQ(identify::transitions_offset_K(identify::moved(preset, 60), joule), 0)
      << "without a thermometer no run tells";
}

class IdentifyNiTiCo : public MeasuredData {
 protected:
  std::vector<smaservo::identify::Run> runs(const std::vector<int>& stresses_MPa) const {
    identify::RunOptions options{from_.geometry, {}, {}, {}};
    options.trace.renames = {"temperature_degC=1", "strain_ref=2", "stress_MPa=3"};
    std::vector<smaservo::identify::Run> all;
    for (const int stress : stresses_MPa) {
      all.push_back(
          identify::read_run(file("niticol/" + std::to_string(stress) + " MPa.txt"), options));
    }
    return all;
  }

  const Wire<double> from_ = files::load_wire("flexinol-lt-0.15mm").wire;
};

TEST_F(IdentifyNiTiCo, IsExplainedAtFourStressesTogether) {
  const std::vector<smaservo::identify::Run> measured = runs({7, 50, 150, 200});
  const identify::FitResult fit = identify::fit_wire(from_, measured, {});
  EXPECT_NEAR(fit.moved_K, -93, 5);
  EXPECT_LT(identify::joint_strain_rms(fit).value_or(1), 0.016);
  for (std::size_t i = 0; i < measured.size(); ++i) {
    const auto classics = identify::fit_classics(measured[i]);
    ASSERT_EQ(classics.size(), 3U) << "a cycle that begins hot";
    // At 7 MPa the strain is a sixth of that at 200 MPa; a function fitted to it alone is better.
    for (const identify::ClassicFit& classic : classics) {
      if (i > 0) {
        EXPECT_LT(fit.runs[i].strain.rms, identify::classic_rms(classic, measured[i], 0.04))
            << classic.name << ", " << measured[i].name;
      }
    }
  }
}

TEST_F(IdentifyNiTiCo, ItsHeatFlowIsReadAsTheInstrumentWroteIt) {
  const identify::Run run =
      identify::read_run(file("niticol/DSC.txt"), {from_.geometry, {}, {}, {}});
  ASSERT_EQ(run.kind, identify::RunKind::calorimetry);
  const identify::FitResult fit = identify::fit_wire(from_, {run}, {});
  EXPECT_LT(fit.runs.front().power.rms, 0.02);
  // Two scans at 10 K/min and two at 5 K/min, and the rates are in the file: a wrong rate would
  // leave a third of the peaks.
  EXPECT_LT(fit.runs.front().power.maximum, 0.1);
}

}  // namespace
}  // namespace smaservo::test
