#include "host-sim/commission/end_to_end_cost.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <string_view>

#include "host-sim/identify/fit/cost/run_cost.hpp"
#include "host-sim/parallel.hpp"

namespace smaservo::commission {
namespace {

/// What a run without a strain may change, and the prior deviation as a share of that with which
/// `identify` begins, which holds for any wire. Between pieces of one type the strain differs by
/// 0.12 %, a ratio of resistivities by 1 to 2 %, a modulus by 8 %. More parameters (transition
/// temperatures, widths, convection, heat capacity) changed the error on the tuning wires by less
/// than 0.1 % of the stroke.
const std::map<std::string_view, double>& free_parameters() {
  static const std::map<std::string_view, double> shares{{"wire.martensite.strain", 0.15},
                                                         {"wire.r_phase.resistivity_ratio", 0.3},
                                                         {"wire.austenite.resistivity_ratio", 0.3},
                                                         {"wire.martensite.modulus", 0.2},
                                                         {"wire.r_phase.modulus", 0.2},
                                                         {"wire.austenite.modulus", 0.2}};
  return shares;
}

/// The resistance of a block errs by this, relatively, and all of them together tell as much as so
/// many independent ones. Between 10 and 800 the error on the tuning wires is the same.
constexpr double innovation_sd = 3e-3;
constexpr double independent_blocks = 50;
// What the observer's slow states may need to agree with the run: a type's convection is known
// within 20 %; the factor on the resistance was measured at the beginning.
constexpr double loss_sd = 0.2;
constexpr double resistance_sd = 0.005;
/// The model's own error of a strain at a reading.
constexpr double model_strain_sd = 3e-4;
constexpr double zero_step = 0.01;        ///< strain for a deviation of 1 of the zero
constexpr double derivative_step = 0.25;  ///< of the numerical derivatives: the observer has kinks

identify::FitVariant variant_of(const Wire<double>& wire) {
  identify::FitVariant variant;
  variant.separate_r2a = wire.kinetics.separate_r2a;
  variant.separate_r2m = wire.kinetics.separate_r2m;
  variant.memory = wire.kinetics.memory;
  variant.mixture = wire.material.mixture;
  return variant;
}

}  // namespace

Beginning::Beginning(const Wire<double>& wire) : from_(wire), variant_(variant_of(wire)) {
  for (identify::FitParameter parameter : identify::fit_parameters(from_, variant_)) {
    const auto share = free_parameters().find(parameter.key);
    if (share != free_parameters().end()) {
      parameter.sd *= share->second;
      parameters_.push_back(std::move(parameter));
    }
  }
}

Wire<double> Beginning::wire(const double* u) const {
  std::size_t next = 0;
  return identify::vary_wire<double>(from_, variant_, [&](const identify::FitParameter& parameter) {
    if (next == parameters_.size() || parameter.key != parameters_[next].key) {
      return parameter.value(0.0);
    }
    const double value = parameters_[next].value(u[next]);
    ++next;
    return value;
  });
}

EndToEndCost::EndToEndCost(const Beginning& beginning, const ObservedWire& seen,
                           const PlacedAnchors& readings, double ambient_sd_K, int threads)
    : beginning_(beginning),
      seen_(seen),
      readings_(readings),
      ambient_sd_K_(ambient_sd_K),
      threads_(threads) {
  const std::vector<double> none(size(), 0.0);
  const Passage first = passage(none.data());
  const std::vector<Anchor>& anchors = readings_.anchors;
  for (std::size_t i = 0; i < anchors.size() && !(readings_.zero_sd > 0); ++i) {
    first_zero_ += (first.at_anchors[i] + anchors[i].displacement_m / readings_.length_m) /
                   static_cast<double>(anchors.size());
  }
  set_num_residuals(static_cast<int>(residuals(first, none.data()).size()));
  mutable_parameter_block_sizes()->push_back(static_cast<int>(size()));
}

double EndToEndCost::zero(const double* u) const {
  return has_zero() ? first_zero_ + zero_step * u[beginning_.parameters().size()] : 0;
}

double EndToEndCost::anchor_residual(std::size_t i, const Passage& passage, const double* u) const {
  const Anchor& anchor = readings_.anchors[i];
  const double read = zero(u) - anchor.displacement_m / readings_.length_m;
  return (passage.at_anchors[i] - read) /
         std::hypot(anchor.sd_m / readings_.length_m, model_strain_sd);
}

Eigen::VectorXd EndToEndCost::residuals(const Passage& passage, const double* u) const {
  std::vector<double> all;
  all.reserve(passage.innovation.size() + readings_.anchors.size() + size() + 3);
  const auto blocks = static_cast<double>(passage.innovation.size());
  const double share = std::sqrt(std::min(1.0, independent_blocks / blocks));
  for (const double innovation : passage.innovation) {
    all.push_back(share * identify::robust(innovation / innovation_sd));
  }
  for (std::size_t i = 0; i < readings_.anchors.size(); ++i) {
    all.push_back(anchor_residual(i, passage, u));
  }
  all.push_back(passage.ambient_off_K / ambient_sd_K_);
  all.push_back(std::log(passage.loss) / loss_sd);
  all.push_back((passage.resistance - 1) / resistance_sd);
  if (readings_.zero_sd > 0 && has_zero()) {
    all.push_back(zero(u) / readings_.zero_sd);
  }
  all.insert(all.end(), u, u + beginning_.parameters().size());
  return Eigen::Map<const Eigen::VectorXd>(all.data(), static_cast<Eigen::Index>(all.size()));
}

EndToEndCost::Linear EndToEndCost::linear(const double* u) const {
  const std::size_t n = size();
  struct Side {
    Eigen::VectorXd residuals, strain;
  };
  std::vector<Side> sides(2 * n);
  parallel(
      sides.size(), threads_,
      [&](std::size_t i) {
        std::vector<double> at(u, u + n);
        at[i / 2] += i % 2 == 0 ? derivative_step : -derivative_step;
        const Passage there = passage(at.data());
        sides[i] = {residuals(there, at.data()),
                    Eigen::Map<const Eigen::VectorXd>(
                        there.strain.data(), static_cast<Eigen::Index>(there.strain.size()))};
      },
      [](std::size_t /*done*/) {});
  Linear all{Eigen::MatrixXd(num_residuals(), static_cast<Eigen::Index>(n)),
             Eigen::MatrixXd(sides[0].strain.size(), static_cast<Eigen::Index>(n))};
  for (std::size_t k = 0; k < n; ++k) {
    const auto column = static_cast<Eigen::Index>(k);
    all.residuals.col(column) =
        (sides[2 * k].residuals - sides[2 * k + 1].residuals) / (2 * derivative_step);
    all.strain.col(column) =
        (sides[2 * k].strain - sides[2 * k + 1].strain) / (2 * derivative_step);
  }
  return all;
}

bool EndToEndCost::Evaluate(double const* const* parameters, double* residuals,
                            double** jacobians) const {
  const double* u = parameters[0];
  Eigen::Map<Eigen::VectorXd>(residuals, num_residuals()) = this->residuals(passage(u), u);
  if (jacobians != nullptr && jacobians[0] != nullptr) {
    using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    Eigen::Map<RowMajor>(jacobians[0], num_residuals(), static_cast<Eigen::Index>(size())) =
        linear(u).residuals;
  }
  return true;
}

}  // namespace smaservo::commission
