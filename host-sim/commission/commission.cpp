#include "host-sim/commission/commission.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <ceres/ceres.h>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <memory>
#include <tuple>
#include <utility>

#include "host-sim/commission/broad.hpp"
#include "host-sim/commission/end_to_end_cost.hpp"
#include "host-sim/commission/limits.hpp"
#include "host-sim/commission/scaled.hpp"
#include "host-sim/identify/fitted_wire.hpp"
#include "model/files/error.hpp"
#include "model/units.hpp"
#include "model/wire/plant.hpp"
#include "observer/estimator.hpp"

namespace smaservo::commission {
namespace {

constexpr double rest_s = 0.2;        ///< for which the run must begin at rest
constexpr double rest_above_K = 10;   ///< a wire at rest is not warmer above the air
constexpr double air_known_sd_K = 3;  ///< a thermometer nearby
constexpr double air_guess_sd_K = 10;
/// Readings of a wire that contracts by more than this are in a wrong unit.
constexpr double longest_stroke = 0.15;
/// Readings farther from the fit than this many of their standard deviations are wrong, or the wire
/// is not of this kind.
constexpr double contradicted_sd = 4;
/// The run has to lead the wire through at least this share of its nominal stroke.
constexpr double least_stroke = 0.5;
/// The resistance of a wire of the type is explained much better (README.md).
constexpr double largest_innovation = 0.015;
/// Readings tell something of the kinetics if they are of places that are this share of the stroke
/// apart, and know them better than that.
constexpr double least_span = 0.5;
/// Of so many readings from the type. Of 48 tuning wires none is beyond 2.4 with two readings, and
/// 3.3 with six.
double most_distance(std::size_t readings) {
  return std::sqrt(9 + 1.5 * static_cast<double>(readings));
}
constexpr double longest_row_s = 0.05;
constexpr int max_iterations = 12;
/// The deviation of the strain that no parameter explains, as a share of the stroke, from what is
/// left on the tuning wires (README.md, 'What it reaches'). Without readings nothing has checked
/// the kinetics.
constexpr double structure_sd = 0.015;
constexpr double unchecked_structure_sd = 0.025;
/// Factors on the accuracy of the type's strain, with which 92 to 98 % of the observer's errors on
/// the tuning wires are within twice the reported deviation.
constexpr double accuracy_without = 1.2, accuracy_of_stroke = 1, accuracy_of_length = 0.6;
constexpr double mean_of_normal = 0.7979;  ///< of the magnitude, for a standard deviation of 1

[[noreturn]] void fail(const identify::Run& run, const std::string& what) {
  throw files::UserError(fmt::format("{}: {}", run.name, what));
}

double air_of(const identify::Run& run, const CommissionOptions& options) {
  for (const double ambient_K : run.ambient_K) {
    if (!std::isnan(ambient_K)) {
      return ambient_K;
    }
  }
  return options.ambient_K.value_or(room_K);
}

identify::ObservedRun observed(const Wire<double>& from, const identify::Run& run,
                               double ambient_K) {
  identify::Assumed<double> assumed{};
  assumed.wire = from;
  assumed.circuit.load_gain = 1;
  assumed.here.ambient_K = ambient_K;
  return identify::observed_run(run, assumed);
}

void check_rows(const identify::Run& run) {
  const auto rows = static_cast<double>(run.time_s.size());
  const double row_s = (run.time_s.back() - run.time_s.front()) / std::max(rows - 1, 1.0);
  if (row_s > longest_row_s) {
    fail(run, fmt::format("has {:.3g} rows/s; at least {:.0f} are needed, better 100", 1 / row_s,
                          1 / longest_row_s));
  }
  if (std::isnan(run.stress_Pa.front())) {
    fail(run, "has no load in its first row");
  }
  double stress_Pa = 0;
  for (const double at : run.stress_Pa) {
    stress_Pa += std::isnan(at) ? 0 : at / rows;
  }
  if (stress_Pa < least_stress_Pa) {
    fail(run, fmt::format("has a load of {:.2g} MPa on average; the wire has to pull a load of at "
                          "least {:.0f} MPa, or its length says nothing",
                          1e-6 * stress_Pa, 1e-6 * least_stress_Pa));
  }
}

/// The resistance at rest, at the beginning.
double resting_ohm(const Wire<double>& from, const identify::Run& run,
                   const identify::ObservedRun& seen) {
  const ThermalBody<double> body = thermal_body(from.geometry, from.heat);
  const double warm_W = body.loss_W(rest_above_K);
  std::vector<double> ohms;
  double now_s = 0;
  for (std::size_t i = 0; i < seen.dt_s.size() && now_s < rest_s; ++i) {
    now_s += seen.dt_s[i];
    if (seen.seen[i].power_W > warm_W) {
      fail(run, fmt::format("heats the wire with {:.0f} mW in the first 0.2 s; it has to begin "
                            "with the cold wire at rest, under a current that only measures "
                            "(at most {:.0f} mW)",
                            1e3 * seen.seen[i].power_W, 1e3 * warm_W));
    }
    if (seen.seen[i].resistance_valid) {
      ohms.push_back(seen.seen[i].resistance_ohm);
    }
  }
  if (ohms.empty()) {
    fail(run, fmt::format("has no resistance in the first 0.2 s; let a current of at least "
                          "{:.1f} mA flow from the beginning on, and see that no lead is open",
                          1e3 * good_front_end(from).min_current_A));
  }
  std::ranges::nth_element(ohms, ohms.begin() + static_cast<std::ptrdiff_t>(ohms.size() / 2));
  return ohms[ohms.size() / 2];
}

double model_ohm_at_rest(const Wire<double>& wire, double ambient_K, double stress_Pa) {
  using Model = Plant<ThreePhase<double>>;
  const auto params = plant_params(wire);
  return Model::resistance_ohm(params, Model::rest(params, {ambient_K, stress_Pa}), ambient_K);
}

void check_cold_resistance(const Wire<double>& from, const identify::Run& run, double ohm,
                           double factor) {
  if (std::abs(factor - 1) <= most_cold_deviation) {
    return;
  }
  const Geometry<double>& g = from.geometry;
  fail(run,
       fmt::format(
           "the cold wire has {:.3g} ohm, a wire of this type and size {:.3g} ohm. A length of "
           "{:.1f} mm in place of {:.1f} mm would explain it, or a diameter of {:.0f} um in "
           "place of {:.0f} um; otherwise it is another alloy, or the voltage is not measured at "
           "the wire's ends",
           ohm, ohm / factor, 1e3 * g.length_m * factor, 1e3 * g.length_m,
           1e6 * g.diameter_m / std::sqrt(factor), 1e6 * g.diameter_m));
}

/// Sorts them by time; returns after which steps they are.
std::vector<std::size_t> place(std::vector<Anchor>& anchors, const identify::Run& run,
                               const identify::ObservedRun& seen, const Wire<double>& from,
                               Zero zero) {
  std::ranges::sort(anchors, {}, [](const Anchor& a) {
    return std::tuple(a.time_s, a.displacement_m, a.sd_m);  // in any order the same result
  });
  if (anchors.size() == 1 && zero == Zero::common) {
    throw files::UserError(
        "one reading alone tells nothing, since its zero is anywhere; give a second one, such as 0 "
        "for the cold wire, or say by --zero length that displacements count from the wire's own "
        "length");
  }
  const double length_m = from.geometry.length_m;
  std::vector<std::size_t> steps;
  std::size_t step = 0;
  double end_s = run.time_s.front() + seen.dt_s.front();
  double low_m = 0, high_m = 0;
  for (const Anchor& anchor : anchors) {
    if (anchor.time_s < run.time_s.front() || anchor.time_s > run.time_s.back()) {
      throw files::UserError(
          fmt::format("the reading at {:g} s is outside of {}, which is from {:g} "
                      "to {:g} s",
                      anchor.time_s, run.name, run.time_s.front(), run.time_s.back()));
    }
    const bool first = &anchor == &anchors.front();
    low_m = first ? anchor.displacement_m : std::min(low_m, anchor.displacement_m);
    high_m = first ? anchor.displacement_m : std::max(high_m, anchor.displacement_m);
    const double farthest_m = zero == Zero::length ? std::max(-low_m, high_m) : high_m - low_m;
    if (farthest_m > longest_stroke * length_m) {
      throw files::UserError(fmt::format(
          "the reading {:g} mm at {:g} s: no wire of {:g} mm moves by {:.3g} mm; is it in mm, and "
          "{}?",
          1e3 * anchor.displacement_m, anchor.time_s, 1e3 * length_m, 1e3 * farthest_m,
          zero == Zero::length ? "from where the wire has its own length (--zero length)"
                               : "from the same zero as the others"));
    }
    while (step + 1 < seen.dt_s.size() && end_s < anchor.time_s) {
      end_s += seen.dt_s[++step];
    }
    steps.push_back(step);
  }
  return steps;
}

/// A beginning with what the run has made of it.
struct Fitted {
  std::unique_ptr<Beginning> beginning;
  std::unique_ptr<EndToEndCost> cost;
  std::vector<double> u;
  double cost_left = std::numeric_limits<double>::infinity();
  bool broad = false;
};

class Watch final : public ceres::IterationCallback {
 public:
  Watch(const std::function<bool(double)>& proceed, double from, double to)
      : proceed_(proceed), from_(from), to_(to) {}
  ceres::CallbackReturnType operator()(const ceres::IterationSummary& summary) override {
    const double share = std::min(1.0, summary.iteration / static_cast<double>(max_iterations));
    if (proceed_(from_ + (to_ - from_) * share)) {
      return ceres::SOLVER_CONTINUE;
    }
    stopped_ = true;
    return ceres::SOLVER_ABORT;
  }
  bool stopped() const { return stopped_; }

 private:
  const std::function<bool(double)>& proceed_;
  double from_, to_;
  bool stopped_ = false;
};

class EndToEndFit {
 public:
  EndToEndFit(const Wire<double>& from, const identify::Run& run, std::vector<Anchor> anchors,
              const CommissionOptions& options)
      : run_(run), options_(options), anchors_(std::move(anchors)) {
    seen_.ambient_K = air_of(run, options);
    seen_.run = observed(from, run, seen_.ambient_K);
    check_rows(run);
    result_.cold_ohm = resting_ohm(from, run, seen_.run);
    result_.cold_factor = result_.cold_ohm / rest_ohm(from);
    check_cold_resistance(from, run, result_.cold_ohm, result_.cold_factor);
    from_ = with_resistance(from, result_.cold_factor);
    seen_.anchor_steps = place(anchors_, run, seen_.run, from, options.zero);
  }

  Commissioned result() {
    Fitted best = fitted(from_, false, 0, 0.5);
    const std::vector<double> none(best.cost->size(), 0.0);
    const Passage before = best.cost->passage(none.data());
    checked_ = spans(before);
    describe(before, result_.trace_before, result_.innovation_before);
    result_.before = expected(*best.cost, none.data(), false);
    for (std::size_t i = 0; i < anchors_.size(); ++i) {
      result_.anchors.push_back(
          {anchors_[i], displacement_m(*best.cost, none.data(), before, i), 0});
    }
    result_.ahead = std::numeric_limits<double>::quiet_NaN();
    if (checked_) {
      const Wire<double> broad = broad_wire(from_);
      Fitted other =
          fitted(with_resistance(broad, result_.cold_ohm / rest_ohm(broad)), true, 0.5, 1);
      result_.ahead = std::abs(other.cost_left - best.cost_left);
      if (other.cost_left < best.cost_left) {
        best = std::move(other);
      }
    }
    finish(best);
    return std::move(result_);
  }

 private:
  /// Whether the readings are of two places, by where the type's observer is then.
  bool spans(const Passage& passage) const {
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (std::size_t i = 0; i < anchors_.size(); ++i) {
      if (anchors_[i].sd_m < least_span / 2 * from_.nominal_stroke * from_.geometry.length_m) {
        low = std::min(low, passage.at_anchors[i]);
        high = std::max(high, passage.at_anchors[i]);
      }
    }
    return high - low >= least_span * from_.nominal_stroke;
  }
  double accuracy_factor() const {
    return !checked_                       ? accuracy_without
           : options_.zero == Zero::length ? accuracy_of_length
                                           : accuracy_of_stroke;
  }

  double rest_ohm(const Wire<double>& wire) const {
    return model_ohm_at_rest(wire, seen_.ambient_K, run_.stress_Pa.front());
  }

  Fitted fitted(const Wire<double>& wire, bool broad, double from_share, double to_share) {
    Fitted all;
    all.broad = broad;
    all.beginning = std::make_unique<Beginning>(wire);
    const bool air_known = options_.ambient_K.has_value() || !run_.ambient_K.empty();
    all.cost = std::make_unique<EndToEndCost>(
        *all.beginning, seen_,
        PlacedAnchors{
            anchors_,
            options_.zero == Zero::length ? options_.length_sd_m / wire.geometry.length_m : 0,
            wire.geometry.length_m},
        air_known ? air_known_sd_K : air_guess_sd_K, options_.threads);
    all.u.assign(all.cost->size(), 0.0);
    ceres::Problem::Options ownership;
    ownership.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    ceres::Problem problem(ownership);
    problem.AddResidualBlock(all.cost.get(), nullptr, all.u.data());
    ceres::Solver::Options solver;
    solver.linear_solver_type = ceres::DENSE_QR;
    solver.max_num_iterations = max_iterations;
    solver.initial_trust_region_radius = 3;
    solver.function_tolerance = 1e-3;
    solver.logging_type = ceres::SILENT;
    Watch watch(options_.proceed, from_share, to_share);
    solver.callbacks.push_back(&watch);
    ceres::Solver::Summary summary;
    ceres::Solve(solver, &problem, &summary);
    if (watch.stopped()) {
      throw files::UserError("interrupted; nothing was written");
    }
    if (!summary.IsSolutionUsable()) {
      fail(run_,
           "the observer cannot follow it; are current, voltage and load numbers from the "
           "first row on?");
    }
    all.cost_left = summary.final_cost;
    return all;
  }

  /// Of a reading, where the observer was then: the displacement from the readings' zero.
  double displacement_m(const EndToEndCost& cost, const double* u, const Passage& passage,
                        std::size_t i) const {
    return (cost.zero(u) - passage.at_anchors[i]) * from_.geometry.length_m;
  }

  void describe(const Passage& passage, Trace& trace, double& innovation) const {
    trace = {passage.time_s, passage.strain, passage.strain_sd, passage.resistance_ohm,
             passage.resistance_model_ohm};
    for (double& time_s : trace.time_s) {
      time_s += run_.time_s.front();
    }
    innovation = innovation_rms(passage);
  }

  /// With the covariance of the parameters that the run and the readings leave, (JᵀJ)⁻¹; without
  /// them that of the prior.
  ExpectedError expected(const EndToEndCost& cost, const double* u, bool after) {
    const EndToEndCost::Linear by = cost.linear(u);
    const auto n = static_cast<Eigen::Index>(cost.size());
    Eigen::MatrixXd covariance = Eigen::MatrixXd::Identity(n, n);
    if (after) {
      const Eigen::MatrixXd information = by.residuals.transpose() * by.residuals;
      covariance = information.ldlt().solve(covariance);
      covariance_ = covariance;
    }
    const double stroke = from_.nominal_stroke;
    const double structure = checked_ ? structure_sd : unchecked_structure_sd;
    const auto mean = [&](const Eigen::MatrixXd& slopes) {
      double sum = 0;
      for (Eigen::Index i = 0; i < slopes.rows(); ++i) {
        const double variance = slopes.row(i) * covariance * slopes.row(i).transpose();
        sum += std::hypot(std::sqrt(std::max(variance, 0.0)) / stroke, structure);
      }
      return mean_of_normal * sum / static_cast<double>(slopes.rows());
    };
    return {mean(by.strain), mean(by.strain.rowwise() - by.strain.row(0))};
  }

  void finish(const Fitted& best) {
    const double* u = best.u.data();
    result_.broad = best.broad;
    result_.wire = best.beginning->wire(u);
    result_.wire.accuracy.strain *= accuracy_factor();
    const Passage after = best.cost->passage(u);
    describe(after, result_.trace_after, result_.innovation_after);
    result_.after = expected(*best.cost, u, true);
    for (std::size_t i = 0; i < anchors_.size(); ++i) {
      result_.anchors[i].after_m = displacement_m(*best.cost, u, after, i);
    }
    const std::vector<identify::FitParameter>& parameters = best.beginning->parameters();
    for (std::size_t k = 0; k < parameters.size(); ++k) {
      const auto at = static_cast<Eigen::Index>(k);
      const double uncertainty = std::sqrt(std::max(covariance_(at, at), 0.0));
      result_.parameters.push_back({parameters[k], parameters[k].value(u[k]),
                                    parameters[k].sd * uncertainty, uncertainty,
                                    uncertainty < 0.5 || std::abs(u[k]) > 2 * uncertainty});
    }
    double squares = 0;
    for (std::size_t k = 0; k < best.u.size(); ++k) {
      const bool is_parameter = k < parameters.size();
      const double off = is_parameter ? u[k]
                         : options_.zero == Zero::length
                             ? best.cost->zero(u) * from_.geometry.length_m / options_.length_sd_m
                             : 0;
      squares += off * off;
    }
    for (std::size_t i = 0; i < anchors_.size(); ++i) {
      const double off = best.cost->anchor_residual(i, after, u);
      squares += off * off;
    }
    result_.distance = std::sqrt(squares);
    check(best, after, u);
  }

  /// What was read, and what would fit.
  std::string readings_text() const {
    std::string all;
    for (const AnchorFit& fit : result_.anchors) {
      all += fmt::format("{}{:g} mm at {:g} s ({:.3g} would fit)", all.empty() ? "" : ", ",
                         1e3 * fit.anchor.displacement_m, fit.anchor.time_s, 1e3 * fit.after_m);
      if (all.size() > 300) {
        return all + ", ...";
      }
    }
    return all;
  }

  void check_anchors(const Fitted& best, const Passage& after, const double* u) const {
    if (anchors_.empty()) {
      return;
    }
    if (options_.zero == Zero::length) {
      const double off_m = best.cost->zero(u) * from_.geometry.length_m;
      if (std::abs(off_m) > contradicted_sd * options_.length_sd_m) {
        throw files::UserError(fmt::format(
            "all readings are {:+.2g} mm from where a wire of this type and of {:g} mm would be. "
            "Is wire.length right? Its deviation was given as {:g} mm (--length-sd-mm). With "
            "--zero "
            "common it does not matter",
            1e3 * off_m, 1e3 * from_.geometry.length_m, 1e3 * options_.length_sd_m));
      }
    }
    for (std::size_t i = 0; i < anchors_.size(); ++i) {
      if (!(std::abs(best.cost->anchor_residual(i, after, u)) <= contradicted_sd)) {
        throw files::UserError(fmt::format(
            "the readings are none of a wire of this type, even after the fit: {}. Are times, "
            "signs (shorter is more) and units right? A doubtful reading can have a greater "
            "deviation: "
            "TIME_S,DISPLACEMENT_MM,SD_MM",
            readings_text()));
      }
    }
    const double most = most_distance(anchors_.size());
    if (!(result_.distance <= most)) {
      throw files::UserError(fmt::format(
          "the readings are {:.1f} standard deviations from what pieces of this type do (allowed: "
          "{:.1f}): {}, with a martensite.strain of {:.3g} %, where the type has {:.3g} %. Are "
          "readings, wire.length and type right?",
          result_.distance, most, readings_text(), 100 * result_.wire.material.martensite.strain,
          100 * from_.material.martensite.strain));
    }
  }

  void check(const Fitted& best, const Passage& after, const double* u) const {
    check_anchors(best, after, u);
    const auto [low, high] = std::ranges::minmax(after.strain);
    const double stroke = (high - low) / from_.nominal_stroke;
    if (!(stroke >= least_stroke)) {
      fail(run_,
           fmt::format("leads the wire through {:.0f} % of its stroke only; heat it until "
                       "its resistance falls no further, and let it cool to the air in between",
                       100 * stroke));
    }
    if (!(result_.innovation_after <= largest_innovation)) {
      fail(run_,
           fmt::format("the resistance differs from that of a wire of this type by {:.1f} % on "
                       "average, after the fit; is it this type, with the right diameter and "
                       "load?",
                       100 * result_.innovation_after));
    }
  }

  const identify::Run& run_;
  const CommissionOptions& options_;
  std::vector<Anchor> anchors_;
  Wire<double> from_{};
  ObservedWire seen_;
  Eigen::MatrixXd covariance_;
  bool checked_ = false;  ///< the readings span enough of the stroke to check the kinetics
  Commissioned result_{};
};

}  // namespace

Commissioned commission(const Wire<double>& from, const identify::Run& run,
                        std::vector<Anchor> anchors, const CommissionOptions& options) {
  return EndToEndFit(from, run, std::move(anchors), options).result();
}

}  // namespace smaservo::commission
