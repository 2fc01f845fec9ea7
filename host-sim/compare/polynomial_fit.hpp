#pragma once

#include <Eigen/QR>
#include <vector>

namespace smaservo {

/// Coefficients by rising power of the least-squares polynomial; more points than the order, x of
/// the order of one.
inline std::vector<double> fit_polynomial(const std::vector<double>& x,
                                          const std::vector<double>& y, int order) {
  const auto rows = static_cast<Eigen::Index>(x.size());
  Eigen::MatrixXd powers(rows, order + 1);
  Eigen::VectorXd values(rows);
  for (Eigen::Index i = 0; i < rows; ++i) {
    values(i) = y[static_cast<std::size_t>(i)];
    double power = 1;
    for (int k = 0; k <= order; ++k) {
      powers(i, k) = power;
      power *= x[static_cast<std::size_t>(i)];
    }
  }
  const Eigen::VectorXd solved = powers.colPivHouseholderQr().solve(values);
  return {solved.data(), solved.data() + solved.size()};
}

}  // namespace smaservo
