// Strain from the resistance alone.

#include <Eigen/QR>
#include <cmath>
#include <limits>

#include "host-sim/papers/compare/system.hpp"
#include "model/files/error.hpp"

namespace smaservo::compare {
namespace {

constexpr double no_value = std::numeric_limits<double>::quiet_NaN();

/// The first resistance of all runs, as a unit in which the others are of the order of one.
double unit_ohm(const std::vector<identify::Run>& runs) {
  for (const identify::Run& run : runs) {
    for (const double ohm : run.resistance_ohm) {
      if (std::isfinite(ohm)) {
        return ohm;
      }
    }
  }
  throw files::UserError("no run has a resistance");
}

/// The line that a row belongs to: 0 while the resistance falls, 1 while it rises.
class Direction {
 public:
  static constexpr double turn = 0.01;

  std::size_t next(double share) {
    far_ = std::isnan(far_) ? share : rises_ ? std::max(far_, share) : std::min(far_, share);
    if (rises_ ? share < far_ - turn : share > far_ + turn) {
      rises_ = !rises_;
      far_ = share;
    }
    return rises_ ? 1 : 0;
  }

 private:
  bool rises_ = false;
  double far_ = no_value;
};

/// Polynomials of one order: one for each direction, or one for both.
struct Polynomials {
  double ohm;
  int order;
  bool two;
  Eigen::VectorXd coefficients[2];

  std::vector<double> strain(const identify::Run& run) const {
    if (run.resistance_ohm.empty()) {
      return std::vector<double>(run.strain.size(), no_value);
    }
    std::vector<double> all;
    all.reserve(run.resistance_ohm.size());
    Direction direction;
    for (const double reading : run.resistance_ohm) {
      double sum = no_value;
      if (std::isfinite(reading)) {
        const double share = reading / ohm;
        const Eigen::VectorXd& c = coefficients[two ? direction.next(share) : 0];
        sum = 0;
        for (Eigen::Index k = c.size(); k-- > 0;) {
          sum = sum * (share - 1) + c(k);
        }
      } else if (!all.empty()) {
        sum = all.back();  // a device would hold its last value, too
      }
      all.push_back(sum);
    }
    return all;
  }
};

/// Normal equations of one polynomial.
struct Sums {
  explicit Sums(Eigen::Index size)
      : normal(Eigen::MatrixXd::Zero(size, size)), right(Eigen::VectorXd::Zero(size)) {}
  Eigen::MatrixXd normal;
  Eigen::VectorXd right;
};

Polynomials fit(const std::vector<identify::Run>& runs, int order, bool two) {
  const Eigen::Index size = order + 1;
  Polynomials fitted{unit_ohm(runs), order, two, {}};
  Sums sums[2]{Sums(size), Sums(size)};
  for (const identify::Run& run : runs) {
    Direction direction;
    const std::size_t rows = std::min(run.strain.size(), run.resistance_ohm.size());
    for (std::size_t i = 0; i < rows; ++i) {
      if (!std::isfinite(run.resistance_ohm[i]) || !std::isfinite(run.strain[i])) {
        continue;
      }
      const double share = run.resistance_ohm[i] / fitted.ohm;
      Sums& to = sums[two ? direction.next(share) : 0];
      Eigen::VectorXd powers(size);
      for (Eigen::Index k = 0; k < size; ++k) {
        powers(k) = std::pow(share - 1, static_cast<double>(k));
      }
      const double weight = 1 / static_cast<double>(rows);
      to.normal += weight * powers * powers.transpose();
      to.right += weight * run.strain[i] * powers;
    }
  }
  for (int line = 0; line < (two ? 2 : 1); ++line) {
    const auto solver = sums[line].normal.colPivHouseholderQr();
    if (solver.rank() < size) {
      throw files::UserError("no run has strain and resistance over a whole motion");
    }
    fitted.coefficients[line] = solver.solve(sums[line].right);
  }
  return fitted;
}

System system(const char* name, const char* meaning, const std::vector<identify::Run>& runs,
              int order, bool two) {
  const Polynomials fitted = fit(runs, order, two);
  return {name, meaning, (order + 1) * (two ? 2 : 1), "",
          [fitted](const identify::Run& run) { return fitted.strain(run); }};
}

}  // namespace

System one_line(const std::vector<identify::Run>& runs) {
  return system("one line", "strain as a straight line over resistance", runs, 1, false);
}

System polynomial(const std::vector<identify::Run>& runs) {
  return system("polynomial", "of fourth order over resistance", runs, 4, false);
}

System two_lines(const std::vector<identify::Run>& runs) {
  return system("two lines", "one for heating, one for cooling", runs, 1, true);
}

}  // namespace smaservo::compare
