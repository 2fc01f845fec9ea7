// Fits three numbers of a wire to a recording by its resistance: convection, and the resistivities
// of martensite and austenite. `host-sim identify` fits all but length and diameter, with errors.

#include <cmath>
#include <cstdio>
#include <smaservo/hal/replay/board.hpp>
#include <smaservo/model/files/wire/wire_file.hpp>
#include <smaservo/model/wire/wire_plant.hpp>
#include <unsupported/Eigen/LevenbergMarquardt>
#include <unsupported/Eigen/NumericalDiff>
#include <vector>

using namespace smaservo;
namespace {
/// A wire with three of its numbers changed by these factors.
Wire<double> changed(Wire<double> w, const Eigen::VectorXd& factors) {
  w.heat.convection_W_m2K *= factors[0];
  w.material.martensite.resistivity_ohm_m *= factors[1];
  w.material.austenite.resistivity_ohm_m *= factors[2];
  return w;
}

/// How far the model's resistance is from the measured one, for Eigen's solver.
struct Deviations : Eigen::DenseFunctor<double> {
  explicit Deviations(const std::vector<hal::Frame>& frames)
      : DenseFunctor(3, static_cast<int>(frames.size())), run(frames) {}
  int operator()(const Eigen::VectorXd& factors, Eigen::VectorXd& ohm) const {
    WirePlant plant{changed(preset, factors), run[0].load_N};
    for (std::size_t i = 0; i < run.size(); ++i) {
      const WireInput<double> in{.current_A = run[i].current_A, .load_N = run[i].load_N};
      const double measured_ohm = run[i].voltage_V / run[i].current_A;
      ohm[static_cast<Eigen::Index>(i)] = plant.update(in, 1e-3).resistance_ohm - measured_ohm;
    }
    return 0;
  }
  Wire<double> preset = files::load_wire("smartflex-76um").wire;
  std::vector<hal::Frame> run;
};
}  // namespace

int main() {
  std::vector<hal::Frame> run;
  hal::ReplayBoard board(hal::TraceReader("host-sim/traces/150MPa.csv", {}), 0, 1);
  for (hal::Frame frame{}; board.read(frame) == hal::ReadStatus::frame;) {
    run.push_back(frame);
  }
  // Derivatives by changes of a thousandth.
  Eigen::NumericalDiff<Deviations> deviations(Deviations{run}, 1e-6);
  Eigen::LevenbergMarquardt solver(deviations);
  Eigen::VectorXd factors = Eigen::VectorXd::Ones(3);
  Eigen::VectorXd before(run.size());
  deviations(factors, before);
  solver.minimize(factors);
  const auto rows = static_cast<double>(run.size());
  std::printf("error of the resistance %.3f ohm, fitted %.3f ohm\n",
              std::sqrt(before.squaredNorm() / rows), solver.fnorm() / std::sqrt(rows));
  std::printf("convection * %.3f, martensite * %.3f, austenite * %.3f\n", factors[0], factors[1],
              factors[2]);
}
