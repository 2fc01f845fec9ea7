// How hot a fit takes a wire for.

#include <gtest/gtest.h>
#include <random>
#include <vector>

#include "host-sim/identify/fit/fit.hpp"
#include "tests/host-sim/identify/simulated_runs.hpp"
#include "tests/model/wire/test_wires.hpp"

namespace smaservo::test {
namespace {

TEST(IdentifyScale, OnlyABathTellsHowHotTheWireIs) {
  std::mt19937_64 random(21);
  const Wire<double> wire = warmed(paper_wire(), 1.15);
  std::vector<identify::Run> runs;
  for (const double stress_MPa : {50, 250}) {
    runs.push_back(joule_run(wire, stress_MPa * MPa, random));
    runs.back().ambient_K.assign(runs.back().time_s.size(), room_K);
  }
  identify::FitOptions options;
  options.variants = false;
  // 60 K above the air
  const auto lost_W_m2K = [](const HeatParams<double>& heat) {
    return heat.convection_W_m2K + 60 * heat.convection_W_m2K2;
  };
  const auto too_much = [&] {
    const HeatParams<double> fitted = identify::fit_wire(paper_wire(), runs, options).wire.heat;
    return lost_W_m2K(fitted) / lost_W_m2K(wire.heat) - 1;
  };
  EXPECT_GT(too_much(), 0.1) << "as cold as the preset's wire";
  runs.push_back(bath_run(wire, 100 * MPa, random));
  EXPECT_NEAR(too_much(), 0, 0.02);
}

}  // namespace
}  // namespace smaservo::test
