// A small version of the table in observer/README.md, with the two wires in tests/golden/evaluate,
// which `host-sim evaluate --wires` keeps. Bounds have two sides: what has become too good has
// probably become wrong.

#include <filesystem>
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "host-sim/evaluate/evaluate.hpp"
#include "tests/places.hpp"

namespace smaservo::test {
namespace {

struct Expected {
  const char* row;
  double mean, p95;
};

constexpr Expected expected[] = {
    {"standard", 0.56, 1.65},
    {"disturbed", 0.54, 1.51},
    {"light", 0.90, 3.26},
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

}  // namespace
}  // namespace smaservo::test
