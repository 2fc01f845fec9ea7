// A small version of the table in observer/README.md, with the two wires in tests/golden/evaluate,
// which `host-sim evaluate --wires` keeps. Bounds have two sides: what has become too good has
// probably become wrong.

#include <filesystem>
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "firmware/bench/scenario/units.hpp"
#include "host-sim/evaluate/evaluate.hpp"
#include "host-sim/evaluate/runs/calibrate.hpp"
#include "model/files/wire/wire_file.hpp"
#include "tests/places.hpp"

namespace smaservo::test {
namespace {

struct Expected {
  const char* row;
  double mean, p95;
};

constexpr Expected expected[] = {
    {"standard", 0.49, 1.82},
    {"disturbed", 0.50, 1.59},
    {"light", 0.60, 2.14},
};

TEST(EvaluationGuard, CalibratedWiresAreEstimatedAsWellAsTheyWere) {
  evaluate::EvaluateOptions options;
  options.units = 1;
  options.runs = 6;
  options.threads = 2;
  options.wires = (std::filesystem::path(test::source_folder()) / "tests/golden/evaluate").string();
  for (const Expected& one : expected) {
    options.rows.emplace_back(one.row);
  }
  const evaluate::Evaluation evaluation = evaluate::evaluate(options);
  const std::vector<evaluate::RowResult>& rows = evaluation.observers.front().rows;
  ASSERT_EQ(rows.size(), std::size(expected));
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const evaluate::RowFigures& reached = rows[i].all;
    SCOPED_TRACE(fmt::format("reached is {{\"{}\", {:.2f}, {:.2f}}}", expected[i].row,
                             reached.error.mean(), reached.error.quantile(0.95)));
    EXPECT_EQ(reached.lost, 0);
    EXPECT_GT(reached.error.mean(), 0.7 * expected[i].mean);
    EXPECT_LT(reached.error.mean(), 1.4 * expected[i].mean);
    EXPECT_GT(reached.error.quantile(0.95), 0.7 * expected[i].p95);
    EXPECT_LT(reached.error.quantile(0.95), 1.4 * expected[i].p95);
    EXPECT_GT(reached.within_2_sd, 0.88) << "an honest deviation";
  }
}

/// Heat that leaves a wire 100 K above the air, in W for each m2 of its surface.
double lost_W_m2(const HeatParams<double>& heat) {
  return 100 * (heat.convection_W_m2K + 100 * heat.convection_W_m2K2);
}

TEST(EvaluationGuard, CalibratedWiresLoseAsMuchHeatAsTheTrueOnes) {
  for (const hal::Family family : hal::tuning_families) {
    const bench::WireUnit unit = bench::random_unit(family, evaluate::first_test_seed);
    const std::string name = evaluate::calibrated_name(family, evaluate::first_test_seed);
    const files::WireDescription found = files::load_wire(
        (std::filesystem::path(test::source_folder()) / "tests/golden/evaluate" / name).string());
    const double share = lost_W_m2(found.wire.heat) / lost_W_m2(unit.wire.wire.heat);
    fmt::print("{}: {:+.1f} % heat loss\n", name, 100 * (share - 1));
    EXPECT_NEAR(share, 1, 0.08) << name;
  }
}

}  // namespace
}  // namespace smaservo::test
