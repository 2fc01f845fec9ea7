// Plans of calibration runs: within the limits of the wire, and worth more than a triangle.

#include "host-sim/plan/plan.hpp"

#include <algorithm>
#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <limits>
#include <nlohmann/json.hpp>

#include "host-sim/plan/plan_profile.hpp"
#include "model/files/error.hpp"
#include "model/files/wire/wire_file.hpp"
#include "model/wire/plant.hpp"
#include "tests/host-sim/program.hpp"
#include "tests/host-sim/replay/trace_numbers.hpp"

namespace smaservo::test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using Model = Plant<ThreePhase<double>>;

/// Runs of about 25 time constants.
struct Case {
  const char* wire;
  double duration_s;
};
constexpr Case cases[] = {{"smartflex-76um", 20}, {"flexinol-lt-0.15mm", 60}};

plan::PlanOptions options(std::vector<double> stresses_Pa, double duration_s, int threads = 2) {
  plan::PlanOptions o;
  o.stresses_Pa = std::move(stresses_Pa);
  o.duration_s = duration_s;
  o.threads = threads;
  return o;
}

/// The hottest that the wire gets, by four steps for each of the plan's.
double hottest_K(const Wire<double>& wire, const plan::PlannedRun& run, double step_s) {
  const Model::Params params = plant_params(wire);
  Model::State state = Model::rest(params, {room_K, run.stress_Pa});
  double hottest = room_K;
  for (const double current_A : run.current_A) {
    for (int i = 0; i < 4; ++i) {
      const double power_W = current_A * current_A * Model::resistance_ohm(params, state, room_K);
      Model::advance(params, state, {power_W, run.stress_Pa, room_K}, step_s / 4);
      hottest = std::max(hottest, Model::temperature_K(state));
    }
  }
  return hottest;
}

void expect_within_limits(const Wire<double>& wire, const plan::Plan& plan, double duration_s) {
  for (const plan::PlannedRun& run : plan.runs) {
    const auto [min, max] = std::ranges::minmax(run.current_A);
    EXPECT_NEAR(static_cast<double>(run.current_A.size()) * plan.step_s, duration_s, plan.step_s);
    EXPECT_LE(max, plan::plan_current * wire.limits.current_A);
    EXPECT_GT(min, 0.05 * max) << "nothing tells the resistance";
    EXPECT_EQ(run.current_A.front(), min) << "the wire is at rest at first";
    EXPECT_EQ(run.current_A.back(), min);
    const double hottest = hottest_K(wire, run, plan.step_s);
    EXPECT_LT(hottest, wire.limits.temperature_K - plan::plan_margin_K + 0.5);
    EXPECT_NEAR(hottest, std::ranges::max(run.temperature_K), 0.5);
  }
}

TEST(Plan, IsWorthMoreThanATriangleWithinTheLimits) {
  for (const auto& [name, duration_s] : cases) {
    SCOPED_TRACE(name);
    const Wire<double> wire = files::load_wire(name).wire;
    const plan::Plan plan = plan::plan_runs(wire, options({50e6, 150e6}, duration_s));
    ASSERT_EQ(plan.runs.size(), 2U);
    EXPECT_EQ(plan.runs[1].stress_Pa, 150e6);
    expect_within_limits(wire, plan, duration_s);
    for (std::size_t i = 0; i < 2; ++i) {
      EXPECT_NEAR(std::ranges::max(plan.triangles[i].current_A),
                  std::ranges::max(plan.runs[i].current_A), 1e-3 * wire.limits.current_A);
    }
    for (const plan::ExpectedParameter& p : plan.parameters) {
      EXPECT_GT(p.plan, 0) << p.parameter.key;
      EXPECT_LE(p.plan, 1) << p.parameter.key;
    }
    EXPECT_LT(plan::mean_logarithm(plan, &plan::ExpectedParameter::plan),
              plan::mean_logarithm(plan, &plan::ExpectedParameter::triangle) - 0.2);
    EXPECT_GT(plan::determined(plan, &plan::ExpectedParameter::plan),
              plan::determined(plan, &plan::ExpectedParameter::triangle));
  }
}

TEST(Plan, KeepsAColderLimit) {
  Wire<double> wire = files::load_wire("flexinol-lt-0.15mm").wire;
  wire.limits.temperature_K = 350;
  const plan::Plan plan = plan::plan_runs(wire, options({50e6}, 10));
  expect_within_limits(wire, plan, 10);
  EXPECT_GT(std::ranges::max(plan.runs[0].temperature_K), 330) << "the limit is made use of";
}

TEST(Plan, ThreadsMakeNoDifference) {
  const Wire<double> wire = files::load_wire("smartflex-76um").wire;
  const plan::Plan one = plan::plan_runs(wire, options({25e6, 200e6}, 10, 1));
  const plan::Plan two = plan::plan_runs(wire, options({25e6, 200e6}, 10, 2));
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(one.runs[i].current_A, two.runs[i].current_A);
  }
  for (std::size_t i = 0; i < one.parameters.size(); ++i) {
    EXPECT_EQ(one.parameters[i].plan, two.parameters[i].plan);
  }
}

TEST(Plan, ChoosesThreeLoads) {
  const Wire<double> wire = files::load_wire("flexinol-lt-0.15mm").wire;
  const plan::Plan plan = plan::plan_runs(wire, options({}, 10));
  ASSERT_EQ(plan.runs.size(), 3U);
  EXPECT_LT(plan.runs[0].stress_Pa, plan.runs[1].stress_Pa);
  EXPECT_LT(plan.runs[1].stress_Pa, plan.runs[2].stress_Pa);
  EXPECT_LE(plan.runs[2].stress_Pa, wire.limits.stress_Pa);
  const plan::Plan low = plan::plan_runs(wire, options({10e6, 11e6, 12e6}, 10));
  EXPECT_LT(plan::mean_logarithm(plan, &plan::ExpectedParameter::plan),
            plan::mean_logarithm(low, &plan::ExpectedParameter::plan) - 0.1)
      << "loads that are nearly equal say less";
}

TEST(Plan, RefusesWhatTheWireDoesNotBear) {
  const Wire<double> wire = files::load_wire("flexinol-lt-0.15mm").wire;
  const auto message = [&](const plan::PlanOptions& o) -> std::string {
    try {
      plan::plan_runs(wire, o);
    } catch (const files::UserError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(message(options({50e6, 400e6}, 10)),
              HasSubstr("400 MPa: must be above 0 and at most"));
  EXPECT_THAT(message(options({0}, 10)), HasSubstr("above 0"));
  EXPECT_THAT(message(options({std::nan("")}, 10)), HasSubstr("above 0"));
  EXPECT_THAT(message(options({50e6, 50e6}, 10)), HasSubstr("given twice"));
  EXPECT_THAT(message(options({50e6}, 0)), HasSubstr("between 10 and 600 s"));
  EXPECT_THAT(message(options({50e6}, std::nan(""))), HasSubstr("between 10 and 600 s"));
}

TEST(PlanProfile, LevelsBeginAndEndAtRestAndStayInRange) {
  std::mt19937_64 random(5);
  for (int i = 0; i < 300; ++i) {
    const plan::Recipe first = plan::random_recipe(random);
    for (const plan::Recipe& recipe : {first, plan::varied(first, random)}) {
      const std::vector<double> profile = plan::levels(recipe, 1000);
      ASSERT_EQ(profile.size(), 1000U);
      EXPECT_EQ(std::ranges::count(profile.begin(), profile.begin() + 20, 0.0), 20);
      EXPECT_EQ(std::ranges::count(profile.end() - 20, profile.end(), 0.0), 20);
      const auto [min, max] = std::ranges::minmax(profile);
      EXPECT_GE(min, 0);
      EXPECT_LE(max, 1);
      EXPECT_GT(max, 0.8) << "no profile is without a full cycle";
    }
  }
}

TEST(CalibratePlan, WritesAColumnForEachLoad) {
  Program program;
  const Finished f =
      program.run({"calibrate-plan", "flexinol-lt-0.15mm", "--set", "wire.length_mm=120",
                   "--stress-MPa", "25,150", "--duration-s", "10", "--out", "plan.csv"});
  ASSERT_EQ(f.status, 0) << f.err;
  const NumberTable table = parse_numbers(file_text(program.folder() / "plan.csv"));
  EXPECT_THAT(table.names, ElementsAre("time_s", "current_A_25MPa", "current_A_150MPa"));
  EXPECT_EQ(table.columns.at(0).front(), 0);
  EXPECT_NEAR(table.columns.at(0).back(), 10, 0.11);
  EXPECT_THAT(f.out, HasSubstr("wire.m2a.temperature"));
  EXPECT_THAT(f.out, HasSubstr("host-sim identify --from flexinol-lt-0.15mm --set "
                               "wire.length_mm=120 --out mine.toml 25MPa.csv 150MPa.csv"));
}

TEST(CalibratePlan, PrintsTheProfileAndNumbersAsJson) {
  Program program;
  const Finished f = program.run({"calibrate-plan", "smartflex-76um", "--load-N", "0.5",
                                  "--duration-s", "20", "--json", "--report", "plan.html"});
  ASSERT_EQ(f.status, 0) << f.err;
  EXPECT_THAT(f.out, ::testing::StartsWith("time_s,current_A\n0.00,"));
  const nlohmann::json numbers = nlohmann::json::parse(f.err);
  EXPECT_NEAR(numbers["runs"][0]["load_N"].get<double>(), 0.5, 1e-9);
  EXPECT_GT(numbers["ratio"].get<double>(), 1.2);
  EXPECT_GT(numbers["determined"]["plan"], numbers["determined"]["triangle"]);
  EXPECT_THAT(file_text(program.folder() / "plan.html"), HasSubstr("data:image/svg+xml"));
}

TEST(CalibratePlan, SaysWhatIsWrong) {
  Program program;
  const auto error = [&](Program::Texts arguments, int status = 1) {
    arguments.insert(arguments.begin(), "calibrate-plan");
    const Finished f = program.run(arguments);
    EXPECT_EQ(f.status, status) << f.err;
    return f.err;
  };
  EXPECT_THAT(error({"nitinol"}), HasSubstr("nitinol"));
  EXPECT_THAT(error({"smartflex-76um", "--load-N", "30"}), HasSubstr("at most 2.7 N"));
  EXPECT_THAT(error({"smartflex-76um", "--duration-s", "0"}),
              HasSubstr("--duration-s 0: must be between 10 and 600"));
  EXPECT_THAT(error({"smartflex-76um", "--report", "-"}), HasSubstr("standard output"));
  EXPECT_THAT(error({"smartflex-76um", "--load-N", "1", "--stress-MPa", "100"}, 2),
              HasSubstr("excludes"));
  EXPECT_THAT(error({}, 2), HasSubstr("WIRE"));
}

}  // namespace
}  // namespace smaservo::test
