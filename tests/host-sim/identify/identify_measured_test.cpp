// Measured wires: Flexinol in a bath at three stresses, and the settled states of a wire in air;
// what a fit makes of them.

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <iterator>
#include <limits>

#include "host-sim/identify/fitted_wire.hpp"
#include "host-sim/identify/report.hpp"
#include "tests/host-sim/replay/measured_data.hpp"
#include "tests/host-sim/replay/replays.hpp"

namespace smaservo::test {
namespace {

class IdentifyFlexinol : public MeasuredData {
 protected:
  std::string file(int stress_MPa) const {
    return MeasuredData::file("flexinol_" + std::to_string(stress_MPa) + "MPa.csv");
  }

  std::vector<smaservo::identify::Run> runs(const std::vector<int>& stresses_MPa) const {
    std::vector<smaservo::identify::Run> all;
    all.reserve(stresses_MPa.size());
    for (const int stress : stresses_MPa) {
      all.push_back(identify::read_run(file(stress), {from_.wire.geometry, {}, {}, {}}));
    }
    return all;
  }

  const files::WireDescription from_ = files::load_wire("flexinol-lt-0.15mm");
};

TEST_F(IdentifyFlexinol, BeatsTheClassicFunctionsAtAllStressesTogether) {
  const std::vector<smaservo::identify::Run> measured = runs({50, 100, 200});
  const identify::FitResult fit = identify::fit_wire(from_.wire, measured, {});
  const double rms = identify::joint_strain_rms(fit).value_or(1);
  EXPECT_LT(rms, 0.007);
  EXPECT_GT(rms, 0.004) << "below the sensor's own noise and drift";
  for (std::size_t i = 0; i < measured.size(); ++i) {
    const auto classics = identify::fit_classics(measured[i]);
    ASSERT_EQ(classics.size(), 3U);
    for (const identify::ClassicFit& classic : classics) {
      EXPECT_LT(fit.runs[i].strain.rms, identify::classic_rms(classic, measured[i], 0.04))
          << classic.name;
    }
  }
}

TEST_F(IdentifyFlexinol, PredictsTheStressBetween) {
  const identify::FitResult fit = identify::fit_wire(from_.wire, runs({50, 200}), {});
  replay::ReplayOptions options;
  options.trace = file(100);
  options.wire = identify::fitted_wire(from_, fit, "flexinol");
  const Estimated e = estimated(options);
  ASSERT_TRUE(e.result.open_loop);
  std::vector<double> errors = e.column("strain");
  const std::vector<double> reference = e.column("strain_ref");
  double mean = 0;
  for (std::size_t i = 0; i < errors.size(); ++i) {
    errors[i] -= reference[i];
    mean += errors[i] / static_cast<double>(errors.size());
  }
  double squares = 0;
  for (const double error : errors) {
    squares += (error - mean) * (error - mean);  // the strain's zero is not known
  }
  const double rms = std::sqrt(squares / static_cast<double>(errors.size())) / 0.04;
  EXPECT_LT(rms, 0.015);
  EXPECT_GT(rms, 0.005);
}

// The 41 settled states of one heating and cooling are divided into 4 folds. Each fold is predicted
// by a fit to the others.

constexpr std::size_t folds = 4;
constexpr std::size_t hottest_row = 20;

/// Mean absolute error of the strain in rows that a fit has not seen, in shares of the stroke.
using Errors = std::vector<double>;
double mean(const Errors& errors) {
  double sum = 0;
  std::size_t count = 0;
  for (const double error : errors) {
    if (!std::isnan(error)) {
      sum += std::abs(error);
      ++count;
    }
  }
  return sum / static_cast<double>(count);
}

double stroke(const smaservo::identify::Run& run) {
  const auto [low, high] = std::ranges::minmax(run.strain);
  return high - low;
}

using Rows = std::vector<std::size_t>;

/// A matrix with the powers 1, R, R², ... for each of these rows; R is relative to 2.9 ohm.
Eigen::MatrixXd powers(const smaservo::identify::Run& run, const Rows& rows, int degree) {
  Eigen::MatrixXd m(static_cast<Eigen::Index>(rows.size()), degree + 1);
  for (Eigen::Index k = 0; k < m.rows(); ++k) {
    const double R = run.resistance_ohm[rows[static_cast<std::size_t>(k)]] - 2.9;
    for (Eigen::Index c = 0; c <= degree; ++c) {
      m(k, c) = std::pow(R, static_cast<double>(c));
    }
  }
  return m;
}

/// Sets the errors of a polynomial from resistance to strain. It predicts each fold of these rows
/// after a fit to the other folds.
void polynomial_errors(const smaservo::identify::Run& run, const Rows& rows, int degree,
                       Errors& errors) {
  for (std::size_t fold = 0; fold < folds; ++fold) {
    Rows train, test;
    std::ranges::partition_copy(rows, std::back_inserter(test), std::back_inserter(train),
                                [&](std::size_t i) { return i % folds == fold; });
    Eigen::VectorXd strain(static_cast<Eigen::Index>(train.size()));
    std::ranges::transform(train, strain.begin(), [&](std::size_t i) { return run.strain[i]; });
    const Eigen::VectorXd fit = powers(run, train, degree).colPivHouseholderQr().solve(strain);
    const Eigen::VectorXd predicted = powers(run, test, degree) * fit;
    for (std::size_t k = 0; k < test.size(); ++k) {
      errors[test[k]] =
          (predicted[static_cast<Eigen::Index>(k)] - run.strain[test[k]]) / stroke(run);
    }
  }
}

/// One straight line, and one polynomial of fourth order for each direction.
struct ResistanceErrors {
  Errors line, two_phase;
};
ResistanceErrors resistance_errors(const smaservo::identify::Run& run) {
  Rows heating, cooling;
  for (std::size_t i = 0; i < run.strain.size(); ++i) {
    if (!std::isnan(run.resistance_ohm[i])) {
      (i > hottest_row ? cooling : heating).push_back(i);
    }
  }
  Rows both = heating;
  both.insert(both.end(), cooling.begin(), cooling.end());
  const Errors none(run.strain.size(), std::nan(""));
  ResistanceErrors errors{none, none};
  polynomial_errors(run, both, 1, errors.line);
  polynomial_errors(run, heating, 4, errors.two_phase);
  polynomial_errors(run, cooling, 4, errors.two_phase);
  return errors;
}

struct ModelErrors {
  Errors alone;            ///< errors of the model driven by the power only
  Errors with_resistance;  ///< errors after the resistance has corrected the temperature
};

/// Predicts the rows of one fold. With the resistance, it chooses the air temperature at which
/// prediction and resistance contradict each other least: the air's standard deviation around the
/// fit's is 1 K, that of the resistance is what remains after the fit.
void predict_left_out(const smaservo::identify::Run& run, const identify::FitResult& fit,
                      std::size_t fold, ModelErrors& errors) {
  const identify::FittedRun& fitted = fit.runs.front();
  const identify::FitRun thin = identify::thin_run(run);
  const auto predicted = [&](double warmer_K) {
    identify::Assumed<double> assumed{fit.wire, fit.circuit, fitted.circumstances};
    assumed.here.ambient_K += warmer_K;
    std::vector<identify::Predicted<double>> all;
    identify::predict(thin, assumed, identify::path_of(thin, assumed), all);
    return all;
  };
  double squares = 0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < run.strain.size(); ++i) {
    const double rest = fitted.resistance_given_strain[i] / fitted.resistance_measured[i] - 1;
    if (!std::isnan(fitted.strain_measured[i]) && !std::isnan(rest)) {
      squares += rest * rest;
      ++count;
    }
  }
  const double resistance_sd = std::sqrt(squares / static_cast<double>(count));
  constexpr double air_sd_K = 1;
  std::vector<double> min(run.strain.size(), std::numeric_limits<double>::infinity());
  for (int step = -80; step <= 80; ++step) {
    const double warmer_K = 0.1 * step;
    const std::vector<identify::Predicted<double>> here = predicted(warmer_K);
    for (std::size_t i = fold; i < run.strain.size(); i += folds) {
      const double error = (here[i].strain - run.strain[i]) / stroke(run);
      const double ohm = std::isnan(run.resistance_ohm[i])
                             ? 0
                             : (run.resistance_ohm[i] / here[i].resistance_ohm - 1) / resistance_sd;
      const double contradiction = std::pow(warmer_K / air_sd_K, 2) + ohm * ohm;
      if (contradiction < min[i]) {
        min[i] = contradiction;
        errors.with_resistance[i] = error;
      }
      if (step == 0) {
        errors.alone[i] = error;
      }
    }
  }
}

/// The columns that a fit does not see in the rows that are left out.
enum class Hidden : unsigned char { strain, strain_and_resistance };

ModelErrors model_errors(const smaservo::identify::Run& run, const Wire<double>& from,
                         Hidden hidden) {
  ModelErrors errors{Errors(run.strain.size(), std::nan("")), {}};
  errors.with_resistance = errors.alone;
  for (std::size_t fold = 0; fold < folds; ++fold) {
    smaservo::identify::Run known = run;
    // The strain of the first state, which has no current, is hidden from every fit.
    known.strain[0] = std::nan("");
    for (std::size_t i = fold; i < run.strain.size(); i += folds) {
      known.strain[i] = std::nan("");
      if (hidden == Hidden::strain_and_resistance) {
        known.resistance_ohm[i] = std::nan("");
      }
    }
    predict_left_out(run, identify::fit_wire(from, {known}, {}), fold, errors);
  }
  return errors;
}

class IdentifyStaircase : public MeasuredData {};

TEST_F(IdentifyStaircase, PredictsStatesThatItHasNotSeen) {
  // Diameter and length follow from the measured 3.46 ohm and 16.9 mm: at 0.38 mm (8.3 ohm/m) the
  // length is 417 mm, and the stroke 4 % of it. The load is a guess.
  const Wire<double> from =
      files::load_wire("flexinol-lt-0.38mm", {{"wire.length_mm", "417"}}).wire;
  const smaservo::identify::Run run =
      identify::read_run(file("staircase_even.csv"), {from.geometry, 100e6, {}, {}});
  ASSERT_EQ(run.kind, identify::RunKind::settled);
  ASSERT_EQ(run.strain.size(), 41U);
  EXPECT_NEAR(stroke(run), 16.9 / 417, 1e-4);
  // This fit sees neither strain nor resistance of the rows left out, like the polynomials.
  const ModelErrors unseen = model_errors(run, from, Hidden::strain_and_resistance);
  EXPECT_LT(mean(unseen.with_resistance), 0.015);
  EXPECT_GT(mean(unseen.with_resistance), 0.005) << "less than between neighbouring states";
  EXPECT_LT(mean(unseen.alone), 0.06);
  // This fit sees the resistance of the rows left out, since it can be measured without knowing the
  // strain.
  const ModelErrors measured = model_errors(run, from, Hidden::strain);
  EXPECT_LT(mean(measured.with_resistance), 0.015);
  EXPECT_LT(mean(measured.alone), 0.025);
  RecordProperty("unseen_alone", std::to_string(100 * mean(unseen.alone)));
  RecordProperty("unseen_with_resistance", std::to_string(100 * mean(unseen.with_resistance)));
  RecordProperty("measured_alone", std::to_string(100 * mean(measured.alone)));
  RecordProperty("measured_with_resistance", std::to_string(100 * mean(measured.with_resistance)));
  const ResistanceErrors plain = resistance_errors(run);
  EXPECT_NEAR(mean(plain.two_phase), 0.058, 0.002);
  EXPECT_NEAR(mean(plain.line), 0.081, 0.002);
}

}  // namespace
}  // namespace smaservo::test
