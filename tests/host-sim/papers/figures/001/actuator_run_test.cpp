// What the text of paper 001 says about its figures, held against the numbers behind ours.

#include "host-sim/papers/figures/001/actuator_run.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <gtest/gtest.h>
#include <numbers>

#include "host-sim/papers/figures/figure.hpp"
#include "host-sim/report/picture.hpp"
#include "model/papers/actuators/actuator_file.hpp"
#include "model/units.hpp"

namespace smaservo::figures {
namespace {

class ActuatorRunTest : public testing::Test {
 protected:
  static const papers::DuhemActuator<double>::Params& params() {
    static const auto p = papers::load_actuator(std::string(papers::paper_001_actuator));
    return p;
  }
  static const std::vector<ActuatorSample>& run() {
    static const auto r = run_actuator(params(), paper_001_voltage);
    return r;
  }
  /// Times at which the temperature turns.
  static std::vector<std::size_t> turns() {
    std::vector<std::size_t> all;
    for (std::size_t i = 1; i + 1 < run().size(); ++i) {
      if ((kelvin(i) - kelvin(i - 1)) * (kelvin(i + 1) - kelvin(i)) < 0) {
        all.push_back(i);
      }
    }
    return all;
  }
  static double kelvin(std::size_t i) { return run()[i].output.temperature_K; }
  static double martensite(std::size_t i) { return run()[i].output.martensite; }
};

TEST_F(ActuatorRunTest, EverySampleIsWithinTheModel) {
  for (const ActuatorSample& sample : run()) {
    ASSERT_TRUE(sample.output.temperature_valid) << sample.time_s;
    ASSERT_TRUE(sample.output.strain_valid) << sample.time_s;
    ASSERT_GE(sample.voltage_V, 0);
  }
}

TEST_F(ActuatorRunTest, StrainStaysBelow0105AndStressVariesBy4MPa) {
  double strain = 0;
  double min_Pa = 1e12;
  double max_Pa = 0;
  for (const ActuatorSample& sample : run()) {
    strain = std::max(strain, sample.output.strain);
    min_Pa = std::min(min_Pa, sample.output.stress_Pa);
    max_Pa = std::max(max_Pa, sample.output.stress_Pa);
  }
  std::printf("strain up to %.4f, stress %.2f to %.2f MPa\n", strain, min_Pa / 1e6, max_Pa / 1e6);
  EXPECT_LT(strain, 0.105);
  EXPECT_GT(strain, 0.1);
  EXPECT_NEAR((max_Pa - min_Pa) / 1e6, 4, 0.5);
}

TEST_F(ActuatorRunTest, FirstSwingIsALoopAndLaterOnesAreMinor) {
  const std::vector<std::size_t> turn = turns();
  ASSERT_GE(turn.size(), 12U);
  // Hot, cold, hot, ... each nearer to the one before.
  EXPECT_LT(martensite(turn[0]), 0.03);
  EXPECT_GT(martensite(turn[1]), 0.9);
  double stroke = 1;
  for (std::size_t i = 1; i + 1 < turn.size(); i += 2) {
    const double next = martensite(turn[i]) - martensite(turn[i + 1]);
    EXPECT_GT(next, 0.01);
    EXPECT_LT(next, stroke) << i;
    stroke = next;
  }
}

TEST_F(ActuatorRunTest, MinorLoopsStayInsideTheMajorOne) {
  const auto& kinetics = params().kinetics;
  const auto right = [](const papers::Duhem<double>::Process& process, double T) {
    return 0.5 * std::erfc((T - process.centre_K) / (process.deviation_K * std::numbers::sqrt2));
  };
  for (std::size_t i = 0; i < run().size(); ++i) {
    ASSERT_LE(martensite(i), right(kinetics.m2a, kelvin(i)) + 1e-6) << run()[i].time_s;
    ASSERT_GE(martensite(i), right(kinetics.a2m, kelvin(i)) - 1e-12) << run()[i].time_s;
  }
}

TEST_F(ActuatorRunTest, StrainFallsOnlyWhileTheTemperatureRises) {
  // 001 section II, figure 5.
  const std::vector<std::size_t> turn = turns();
  for (std::size_t i = 1; i < run().size(); ++i) {
    const double strain = run()[i].output.strain - run()[i - 1].output.strain;
    const double warmer_K = kelvin(i) - kelvin(i - 1);
    // A turn itself lies between two samples.
    const bool turns_here = std::ranges::count(turn, i) + std::ranges::count(turn, i - 1) > 0;
    if (!turns_here && std::abs(strain) > 1e-9) {
      ASSERT_LT(strain * warmer_K, 0) << run()[i].time_s;
    }
  }
}

TEST_F(ActuatorRunTest, TemperatureSlowsDownAboveAustenitesAndBelowMartensitesStart) {
  // 001 section II, figure 4, on every swing that gets there at full speed.
  const auto slope_after = [&](std::size_t i) {
    return std::abs(kelvin(i + 3) - kelvin(i + 1)) / 0.2;
  };
  const auto slope_before = [&](std::size_t i) {
    return std::abs(kelvin(i - 1) - kelvin(i - 3)) / 0.2;
  };
  int rising = 0;
  int falling = 0;
  for (std::size_t i = 10; i + 10 < run().size() && run()[i].time_s < 200; ++i) {
    if (kelvin(i - 1) < 58 + zero_degC_K && kelvin(i) >= 58 + zero_degC_K) {
      ++rising;
      EXPECT_LT(slope_after(i + 8), 0.5 * slope_before(i - 3)) << run()[i].time_s;
    }
    if (kelvin(i - 1) > 48 + zero_degC_K && kelvin(i) <= 48 + zero_degC_K) {
      ++falling;
      EXPECT_LT(slope_after(i + 8), 0.5 * slope_before(i)) << run()[i].time_s;
    }
  }
  EXPECT_EQ(rising, 4);
  EXPECT_EQ(falling, 4);
}

TEST_F(ActuatorRunTest, NothingTransformsBetweenTheStarts) {
  // 001 section VII's dead zone; 3.1 % is what Table I's Gaussian leaves in it (duhem_test.cpp).
  for (std::size_t i = 1; i < run().size(); ++i) {
    const bool inside = std::min(kelvin(i), kelvin(i - 1)) > 48 + zero_degC_K &&
                        std::max(kelvin(i), kelvin(i - 1)) < 58 + zero_degC_K;
    if (inside) {
      const double per_K =
          std::abs(martensite(i) - martensite(i - 1)) / std::abs(kelvin(i) - kelvin(i - 1));
      // A tenth of the largest slope of cooling, a fifth of heating's.
      ASSERT_LT(per_K, 0.0065) << run()[i].time_s;
    }
  }
}

TEST_F(ActuatorRunTest, AusteniteHasTheLowerResistance) {
  // 001 figure 13: at 60 °C, martensite before the first turn and austenite after it.
  const auto hot = static_cast<std::ptrdiff_t>(turns()[0]);
  const auto beyond = [](const ActuatorSample& s) {
    return s.output.temperature_K > 60 + zero_degC_K;
  };
  const auto rising = std::ranges::find_if(run(), beyond);
  const auto falling = std::find_if_not(run().begin() + hot, run().end(), beyond);
  EXPECT_LT(falling->output.resistance_ohm, 0.9 * rising->output.resistance_ohm);
}

TEST_F(ActuatorRunTest, MinorLoopsOfFigure7AreScaledCopies) {
  // 001 eq. 8, where the heating curve has ended: below 45 °C it has 0.12 %.
  const auto& cooling = params().kinetics.a2m;
  const std::vector<MinorLoop> loops = minor_loops(params().kinetics);
  ASSERT_EQ(loops.size(), 4U);
  for (std::size_t loop = 0; loop < loops.size(); ++loop) {
    const double n = loops[loop].cooling.front();
    EXPECT_NEAR(n, 1 - 0.25 * static_cast<double>(loop), 0.01);
    for (std::size_t i = 0; i < loops[loop].cooling.size(); ++i) {
      const double T = loops[loop].temperature_K[i];
      const double h =
          0.5 * std::erfc((cooling.centre_K - T) / (cooling.deviation_K * std::numbers::sqrt2));
      if (T < 45 + zero_degC_K) {
        ASSERT_NEAR(loops[loop].cooling[i], n * h, 0.0015);
      }
      ASSERT_LE(loops[loop].heating[i], h + 1e-12);
    }
  }
}

TEST_F(ActuatorRunTest, AllFiguresAreDrawn) {
  const std::vector<PaperFigure> figures = figures_001();
  std::vector<int> numbers;
  for (const PaperFigure& figure : figures) {
    numbers.push_back(figure.number);
    for (const std::string& svg : report::pictures(figure.panels)) {
      EXPECT_NE(svg.find("</svg>"), std::string::npos);
    }
  }
  EXPECT_EQ(numbers, (std::vector{4, 5, 7, 9, 11, 12, 13, 14, 15}));
}

}  // namespace
}  // namespace smaservo::figures
