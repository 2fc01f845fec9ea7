// Two wires that pull a joint to either side: what one gains in length the other loses, and both
// carry the same force.

#include <cstdio>
#include <smaservo/model/files/wire/wire_file.hpp>
#include <smaservo/model/wire/wire_plant.hpp>

using namespace smaservo;
namespace {

constexpr double dt_s = 1e-3;

struct Antagonists {
  WirePlant<double> left, right;
  double strains;  ///< that the frame allows both together

  double too_long(double left_A, double right_A, double load_N) const {
    return left.after({.current_A = left_A, .load_N = load_N}, dt_s).strain +
           right.after({.current_A = right_A, .load_N = load_N}, dt_s).strain - strains;
  }
  /// Makes a step and gives the force: by bisection, since more force makes both wires longer.
  double step(double left_A, double right_A) {
    double low = 0;
    double high = 10;
    for (int i = 0; i < 40; ++i) {
      const double load_N = 0.5 * (low + high);
      (too_long(left_A, right_A, load_N) > 0 ? high : low) = load_N;
    }
    left.update({.current_A = left_A, .load_N = low}, dt_s);
    right.update({.current_A = right_A, .load_N = low}, dt_s);
    return low;
  }
};

}  // namespace

int main() {
  const Wire<double> wire = files::load_wire("smartflex-76um").wire;
  const double length_m = wire.geometry.length_m;
  const WirePlant rested{wire, 0.5};
  // Cold at first: the strains add up to 8.2 %, and the frame allows 4.5 %, so both are slack.
  Antagonists pair{rested, rested, 0.045};

  std::puts("time s  left A  right A  joint mm  force N");
  for (int i = 0; i <= 6000; ++i) {
    const double left_A = i / 1500 % 2 == 0 ? 0.15 : 0;
    const double right_A = i / 1500 % 2 == 1 ? 0.15 : 0;
    const double load_N = pair.step(left_A, right_A);
    if (i % 500 == 499) {
      const double strain = pair.right.output().strain - pair.left.output().strain;
      std::printf("%6.2f  %6.2f  %7.2f  %8.2f  %7.2f\n", i * dt_s, left_A, right_A,
                  0.5e3 * length_m * strain, load_N);
    }
  }
}
