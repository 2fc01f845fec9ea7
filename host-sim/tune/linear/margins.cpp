#include "host-sim/tune/linear/margins.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

namespace smaservo::tune {
namespace {

constexpr double by_decade = 60;
constexpr double none = std::numeric_limits<double>::infinity();

std::vector<double> grid(double low, double high) {
  const double decades = std::log10(high / low);
  const int steps = std::max(2, static_cast<int>(std::ceil(by_decade * decades)));
  std::vector<double> all;
  all.reserve(static_cast<std::size_t>(steps) + 1);
  for (int i = 0; i < steps; ++i) {
    all.push_back(low * std::pow(10, decades * i / steps));
  }
  all.push_back(high);
  return all;
}

/// The frequency between a and b at which f changes its sign.
template <class F>
double sign_change(const F& f, double a, double b) {
  const bool below = f(a) < 0;
  for (int i = 0; i < 40; ++i) {
    const double middle = std::sqrt(a * b);
    ((f(middle) < 0) == below ? a : b) = middle;
  }
  return std::sqrt(a * b);
}

/// The greatest value of f between a and b, where it has one maximum; by golden section search.
template <class F>
double maximum(const F& f, double a, double b) {
  constexpr double share = std::numbers::phi - 1;
  for (int i = 0; i < 30; ++i) {
    const double left = b - share * (b - a);
    const double right = a + share * (b - a);
    (f(left) < f(right) ? a : b) = f(left) < f(right) ? left : right;
  }
  return f(0.5 * (a + b));
}

class Curve {
 public:
  Curve(const OpenLoop& loop, double low, double high) : loop_(loop), omega_(grid(low, high)) {
    for (const double omega : omega_) {
      value_.push_back(loop(omega));
    }
  }

  Margins margins() const {
    Margins m{stable(), none, none, max_sensitivity(), 0, 0};
    for (std::size_t i = 1; i < omega_.size(); ++i) {
      if ((std::abs(value_[i - 1]) < 1) != (std::abs(value_[i]) < 1)) {
        take_unit_crossing(m, i);
      }
      if ((value_[i - 1].imag() < 0) != (value_[i].imag() < 0)) {
        take_real_crossing(m, i);
      }
    }
    // The locus of a sampled loop ends on the real axis, at the Nyquist frequency.
    if (value_.back().real() < 0 && std::abs(value_.back().imag()) < 1e-9) {
      take_gain(m, -value_.back().real(), omega_.back());
    }
    return m;
  }

 private:
  /// The locus of 1 + L begins at the angle that the loop's integrators give, a quarter turn for
  /// each, and must reach the positive real axis without encircling 0.
  bool stable() const {
    const double low = omega_.front();
    const double integrators =
        std::round(std::log2(std::abs(value_.front()) / std::abs(loop_(2 * low))));
    const double begins = -0.5 * std::numbers::pi * integrators;
    const double off = std::arg((1.0 + value_.front()) * std::polar(1.0, -begins));
    double turned = begins + off;
    for (std::size_t i = 1; i < value_.size(); ++i) {
      turned += std::arg((1.0 + value_[i]) / (1.0 + value_[i - 1]));
    }
    return std::abs(off) < 0.5 * std::numbers::pi && std::abs(turned) < 0.5 * std::numbers::pi;
  }

  double max_sensitivity() const {
    const auto at = [&](double omega) { return 1 / std::abs(1.0 + loop_(omega)); };
    std::size_t best = 0;
    for (std::size_t i = 1; i < value_.size(); ++i) {
      best = std::abs(1.0 + value_[i]) < std::abs(1.0 + value_[best]) ? i : best;
    }
    const double low = omega_[best == 0 ? 0 : best - 1];
    const double high = omega_[std::min(best + 1, omega_.size() - 1)];
    return std::max(maximum(at, low, high), 1 / std::abs(1.0 + value_[best]));
  }

  void take_unit_crossing(Margins& m, std::size_t i) const {
    const double omega =
        sign_change([&](double w) { return std::abs(loop_(w)) - 1; }, omega_[i - 1], omega_[i]);
    m.phase_rad = std::min(m.phase_rad, std::numbers::pi - std::abs(std::arg(loop_(omega))));
    m.crossover_rad_s = omega;
  }

  void take_real_crossing(Margins& m, std::size_t i) const {
    const double omega =
        sign_change([&](double w) { return loop_(w).imag(); }, omega_[i - 1], omega_[i]);
    take_gain(m, -loop_(omega).real(), omega);
  }

  static void take_gain(Margins& m, double size, double omega) {
    if (0 < size && size < 1 && 1 / size < m.gain) {
      m.gain = 1 / size;
      m.oscillation_rad_s = omega;
    }
  }

  const OpenLoop& loop_;
  std::vector<double> omega_;
  std::vector<std::complex<double>> value_;
};

}  // namespace

Margins margins(const OpenLoop& loop, double low_rad_s, double high_rad_s) {
  return Curve(loop, low_rad_s, high_rad_s).margins();
}

Margins worse(const Margins& a, const Margins& b) {
  return {a.stable && b.stable,
          std::min(a.gain, b.gain),
          std::min(a.phase_rad, b.phase_rad),
          std::max(a.sensitivity, b.sensitivity),
          (a.phase_rad < b.phase_rad ? a : b).crossover_rad_s,
          (a.gain < b.gain ? a : b).oscillation_rad_s};
}

}  // namespace smaservo::tune
