#pragma once
// The temperature loop of paper 003, section III and figure 3: a fixed linear controller, and an
// adaptive minimum-variance controller with gain scheduling, on a wire that is heated by its
// current. 003 refers to its reference [4] for the equations; those used here are the textbook's
// (Åström and Wittenmark, 'Adaptive Control', chapters 2 and 4).

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "model/wire/wire.hpp"

namespace smaservo::figures {

/// A controller of the wire's temperature, which can only heat, up to a limit.
class TemperatureController {
 public:
  virtual ~TemperatureController() = default;
  /// The power for the sample period that begins now, 0..max_W. `next_K` is the reference at the
  /// end of the period.
  virtual double power_W(double measured_K, double next_K) = 0;
};

/// The plant for which both controllers are designed: the wire without transformation, as one heat
/// capacity.
struct LoopDesign {
  double sample_s;
  double max_W;
  double capacity_J_K;
  double loss_W_K;
  double ambient_K;
};

/// PID with fixed gains, designed by internal model control: with the wire without transformation,
/// the closed loop is of first order with the time constant `response_s`. The derivative acts on
/// the filtered measurement; the integral is frozen at the limits.
class FixedController : public TemperatureController {
 public:
  FixedController(const LoopDesign& design, double response_s);
  double power_W(double measured_K, double next_K) final;

 private:
  LoopDesign design_;
  double gain_W_K_, integral_time_s_, derivative_time_s_;
  double integral_W_ = 0;
  double filtered_K_, filtered_before_K_;
};

/// Recursive least squares with forgetting: y = θᵀφ. While the regressors contain no new
/// information, the covariance stops growing at `largest_trace`.
class RecursiveLeastSquares {
 public:
  using Vector = Eigen::Vector4d;

  RecursiveLeastSquares(const Vector& start, double start_variance, double forgetting,
                        double largest_trace);
  void update(const Vector& regressors, double y);
  const Vector& parameters() const { return parameters_; }

 private:
  Vector parameters_;
  Eigen::Matrix4d covariance_;
  double forgetting_, largest_trace_;
};

struct AdaptiveSettings {
  /// Bounds between the regions that have their own parameters: gain scheduling.
  std::vector<double> region_edges_K;
  double forgetting;     ///< forgetting factor per sample
  double change_weight;  ///< ρ; with 0 the power would follow the thermocouple's noise
};

/// Predicts y(k+1) = a₁ y(k) + a₂ y(k-1) + b u(k) + c, with the parameters of the measurement's
/// region, and applies the power that minimises (r(k+1) - y(k+1))² + ρ (u(k) - u(k-1))², with y in
/// 10 K and u as a share of the greatest power.
class AdaptiveController : public TemperatureController {
 public:
  AdaptiveController(const LoopDesign& design, const AdaptiveSettings& settings);
  double power_W(double measured_K, double next_K) final;

 private:
  std::size_t region(double temperature_K) const;
  double scaled(double temperature_K) const;

  LoopDesign design_;
  AdaptiveSettings settings_;
  std::vector<RecursiveLeastSquares> regions_;
  double before_ = 0;  ///< y(k-1)
  double power_ = 0;   ///< u(k-1)
  RecursiveLeastSquares::Vector regressors_ = RecursiveLeastSquares::Vector::Zero();
  std::optional<std::size_t> predicting_;  ///< the region that made the prediction for this sample
};

/// The reference of temperature and stress at one sample.
struct LoopReference {
  double temperature_K, stress_Pa;
};
struct LoopRow {
  double time_s;
  LoopReference reference, truth;
  double current_A;
};

struct LoopSetup {
  Wire<double> wire;
  double sample_s = 0.02;
  double limit_A;
  double ambient_K = room_K;
  double noise_K = 0.1;       ///< noise of the thermocouple
  double stress_lag_s = 0.2;  ///< time constant of the stress control loop
  std::uint64_t seed = 1;
};

LoopDesign loop_design(const LoopSetup& setup);

/// Runs Plant<ThreePhase>, at rest at the ambient temperature, with the controller, for one sample
/// period after each reference. The power is converted to a current by the wire's present
/// resistance (003 eq. 1).
std::vector<LoopRow> run_loop(const LoopSetup& setup, TemperatureController& controller,
                              const std::vector<LoopReference>& references);

/// Root mean square of true less reference temperature, after the first `skipped_s`.
double tracking_error_K(const std::vector<LoopRow>& rows, double skipped_s);

}  // namespace smaservo::figures
