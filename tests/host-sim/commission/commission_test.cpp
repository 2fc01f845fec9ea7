// Commissioning, judged on units of the simulated families in runs that it has not seen. Half a
// minute.

#include "host-sim/commission/commission.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "host-sim/commission/broad.hpp"
#include "host-sim/evaluate/evaluate.hpp"
#include "model/files/error.hpp"
#include "model/files/wire/wire_file.hpp"
#include "model/wire/plant.hpp"
#include "tests/host-sim/commission/commissioned_run.hpp"

namespace smaservo::test {
namespace {

using commission::Anchor;
using commission::Zero;
using ::testing::AllOf;
using ::testing::HasSubstr;

commission::Commissioned commissioned(const CommissionedRun& run, std::vector<Anchor> anchors,
                                      Zero zero = Zero::common, int threads = 2) {
  commission::CommissionOptions options;
  options.zero = zero;
  options.threads = threads;
  return commission::commission(run.type, run.run, std::move(anchors), options);
}

std::string error_of(const CommissionedRun& run, std::vector<Anchor> anchors,
                     Zero zero = Zero::common) {
  try {
    commissioned(run, std::move(anchors), zero);
  } catch (const files::UserError& error) {
    return error.what();
  }
  return "";
}

std::string toml(const Wire<double>& wire) {
  return files::to_toml({"wire", wire, {}});
}

/// Half of the error, on wires of the model's kind and on others, and more of it where the model is
/// right; and what is reported is what is reached. Read from anywhere, they do the same for
/// the displacement.
TEST(Commission, TwoLengthsHalveTheError) {
  evaluate::EvaluateOptions options;
  options.families = {hal::families.begin(), hal::families.end()};
  options.units = 2;
  options.runs = 48;  // in each row
  options.seed = 500;
  options.threads = 2;
  options.rows = {"uncalibrated", "two-readings", "uncalibrated-stroke", "read-stroke"};
  const evaluate::Evaluation evaluation = evaluate::evaluate(options);
  const evaluate::RowResult& type = evaluation.observers.front().rows[0];
  const evaluate::RowResult& two = evaluation.observers.front().rows[1];
  const evaluate::RowResult& homed = evaluation.observers.front().rows[2];
  const evaluate::RowResult& read = evaluation.observers.front().rows[3];
  EXPECT_LT(two.all.error.mean(), 0.6 * type.all.error.mean());
  for (std::size_t i = 0; i < type.by_family.size(); ++i) {
    const evaluate::RowFigures& before = type.by_family[i].figures;
    const evaluate::RowFigures& after = two.by_family[i].figures;
    EXPECT_LT(after.error.mean(), 0.8 * before.error.mean()) << i;
    EXPECT_GT(after.within_2_sd, 0.85) << i;
    EXPECT_LT(read.by_family[i].figures.error.mean(), 0.8 * homed.by_family[i].figures.error.mean())
        << i;
    EXPECT_GT(read.by_family[i].figures.within_2_sd, 0.85) << i;
  }
  EXPECT_LT(read.all.error.mean(), 0.5 * homed.all.error.mean());
  EXPECT_LT(two.by_family[0].figures.error.mean(), 0.6 * type.by_family[0].figures.error.mean());
}

/// The readings' zero is where somebody has laid the ruler.
TEST(Commission, ACommonZeroDoesNotMatter) {
  const CommissionedRun run(hal::Family::sublayers, 501);
  const commission::Commissioned here = commissioned(run, run.read_cold_and_hot(0));
  const commission::Commissioned there = commissioned(run, run.read_cold_and_hot(0.37));
  EXPECT_NEAR(here.wire.material.martensite.strain, there.wire.material.martensite.strain, 1e-7);
  EXPECT_NEAR(here.after.stroke, there.after.stroke, 1e-5);
  EXPECT_EQ(here.broad, there.broad);
  // Where the zero is the wire's length it does.
  const commission::Commissioned own = commissioned(run, run.read_cold_and_hot(0), Zero::length);
  EXPECT_LT(own.after.strain, 0.8 * here.after.strain);
}

TEST(Commission, IsTheSameForAnyNumberOfThreads) {
  const CommissionedRun run(hal::Family::ihyp, 502);
  const auto with = [&](int threads) {
    return toml(commissioned(run, run.read_cold_and_hot(), Zero::common, threads).wire);
  };
  EXPECT_EQ(with(1), with(3));
}

/// Readings may be given in any order, and one twice counts more.
TEST(Commission, KnowsMoreWithMoreReadings) {
  const CommissionedRun run(hal::Family::ihyp, 503);
  std::vector<Anchor> anchors = run.read_cold_and_hot();
  const commission::Commissioned two = commissioned(run, anchors);
  anchors.push_back(run.read(23.9));
  anchors.push_back(run.read(40.3));
  const commission::Commissioned four = commissioned(run, anchors);
  std::ranges::reverse(anchors);
  EXPECT_EQ(toml(commissioned(run, anchors).wire), toml(four.wire));
  const commission::Commissioned none = commissioned(run, {});
  EXPECT_LT(four.after.stroke, two.after.stroke);
  EXPECT_LT(two.after.stroke, none.after.stroke);
  EXPECT_LE(none.after.stroke, none.before.stroke);
}

/// The structure of the kinetics is never chosen by the resistance alone.
TEST(Commission, LeavesTheTransformationsWithoutReadings) {
  const CommissionedRun run(hal::Family::sublayers, 504);
  const commission::Commissioned none = commissioned(run, {});
  EXPECT_FALSE(none.broad);
  EXPECT_TRUE(std::isnan(none.ahead));
  EXPECT_EQ(none.wire.kinetics.m2a.start_K[0], run.type.kinetics.m2a.start_K[0]);
  EXPECT_EQ(none.wire.kinetics.separate_r2a, run.type.kinetics.separate_r2a);
}

TEST(Commission, ChoosesTheKindOfTheWire) {
  int right = 0;
  for (const std::uint64_t seed : {505U, 506U, 507U}) {
    const CommissionedRun narrow(hal::Family::ihyp, seed);
    right += commissioned(narrow, narrow.read_cold_and_hot(), Zero::length).broad ? 0 : 1;
    const CommissionedRun broad(hal::Family::sublayers, seed);
    right += commissioned(broad, broad.read_cold_and_hot(), Zero::length).broad ? 1 : 0;
  }
  EXPECT_GE(right, 5) << "of 6";
}

TEST(Commission, BroadWiresOfAllPresetsAreWires) {
  for (const std::string_view name : files::preset_names()) {
    const Wire<double> type = files::load_wire(std::string(name)).wire;
    const Wire<double> broad = commission::broad_wire(type);
    EXPECT_NO_THROW(files::parse_wire(toml(broad), std::string(name))) << name;
    EXPECT_NEAR(cold_resistance_ohm(broad), cold_resistance_ohm(type),
                1e-9 * cold_resistance_ohm(type));
  }
}

TEST(Commission, NamesWhatIsNotTheType) {
  CommissionedRun run(hal::Family::ihyp, 508);
  const double length_m = run.type.geometry.length_m;
  run.type.geometry.length_m *= 0.8;
  EXPECT_THAT(error_of(run, {}),
              AllOf(HasSubstr("the cold wire has"), HasSubstr("in place of 80.0 mm")))
      << length_m;
  run.type.geometry.length_m = length_m;
  for (double& voltage_V : run.run.voltage_V) {
    voltage_V *= 0.4;
  }
  EXPECT_THAT(error_of(run, {}), HasSubstr("no resistance in the first 0.2 s"));
}

TEST(Commission, RefusesRunsThatTellNothing) {
  CommissionedRun run(hal::Family::ihyp, 509);
  const auto cut = [&](double from_s, double to_s) {
    CommissionedRun part = run;
    for (auto* column :
         {&part.run.time_s, &part.run.current_A, &part.run.voltage_V, &part.run.stress_Pa}) {
      *column = {column->begin() + static_cast<std::ptrdiff_t>(1e3 * from_s),
                 column->begin() + static_cast<std::ptrdiff_t>(1e3 * to_s)};
    }
    return part;
  };
  EXPECT_THAT(error_of(cut(20, 40), {}), HasSubstr("begin with the cold wire at rest"));
  EXPECT_THAT(error_of(cut(0, 2), {}), HasSubstr("of its stroke only"));
  CommissionedRun unloaded = run;
  unloaded.run.stress_Pa.front() = std::nan("");
  EXPECT_THAT(error_of(unloaded, {}), HasSubstr("no load in its first row"));
}

TEST(Commission, RefusesReadingsThatCannotBe) {
  const CommissionedRun run(hal::Family::ihyp, 510);
  const std::vector<Anchor> good = run.read_cold_and_hot();
  const auto with = [&](Anchor one) {
    std::vector<Anchor> all = good;
    all.push_back(one);
    return error_of(run, all);
  };
  EXPECT_THAT(error_of(run, {good[0]}), HasSubstr("one reading alone tells nothing"));
  EXPECT_EQ(error_of(run, {run.read(1.8)}, Zero::length), "");
  EXPECT_THAT(with({200, 0, 1e-4}), HasSubstr("outside of run.csv"));
  EXPECT_THAT(with({-1, 0, 1e-4}), HasSubstr("outside of run.csv"));
  EXPECT_THAT(with({20, 3, 1e-4}), HasSubstr("is it in mm"));
  // The hot wire as long as the cold one.
  Anchor wrong = good[0];
  wrong.time_s = good[1].time_s;
  EXPECT_THAT(with(wrong), HasSubstr("none of a wire of this type"));
}

/// No observer would be as good as it is told to be.
TEST(Commission, RefusesReadingsOfAnotherStrokeOrLength) {
  const CommissionedRun run(hal::Family::ihyp, 511);
  const std::vector<Anchor> good = run.read_cold_and_hot();
  for (const double factor : {0.6, 1.4}) {
    std::vector<Anchor> other = good;
    other[1].displacement_m =
        good[0].displacement_m + factor * (good[1].displacement_m - good[0].displacement_m);
    EXPECT_NE(error_of(run, other), "") << factor;
  }
  for (const double off_m : {-1e-3, 1e-3}) {
    EXPECT_THAT(error_of(run, run.read_cold_and_hot(off_m), Zero::length),
                HasSubstr("wire.length"));
  }
}

/// Many of one place are no more than one for the choice between kinds of wires.
TEST(Commission, CountsPlacesNotReadings) {
  const CommissionedRun run(hal::Family::sublayers, 512);
  const commission::Commissioned cold = commissioned(run, {run.read(1.5), run.read(1.8)});
  EXPECT_TRUE(std::isnan(cold.ahead));
  Anchor unsure = run.read(32.8);
  unsure.sd_m = 1;
  EXPECT_TRUE(std::isnan(commissioned(run, {run.read(1.8), unsure}).ahead));
}

}  // namespace
}  // namespace smaservo::test
