#pragma once
// The worst relative error of an inverse of the ihyp function, against bisection in long double.

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "model/wire/three_phase/ihyp.hpp"

namespace smaservo::benchmarks {

template <class S>
struct IhypCase {
  IhypShape<S> shape;
  S tau;
};

/// Seeded cases over the whole range: curvature 1e-3..30, turning 0.05..0.95, |tau| <= 1e4; three
/// quarters of them in and around the transformation, the rest spread by order of magnitude.
template <class S>
std::vector<IhypCase<S>> whole_ihyp_range(int count) {
  std::mt19937_64 random(20240);
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  std::vector<IhypCase<S>> cases;
  for (int i = 0; i < count; ++i) {
    const double curvature = std::pow(10, uniform(-3, std::log10(30.0)));
    const double turning = uniform(0.05, 0.95);
    double tau = uniform(-1, 2);
    if (i % 4 == 0) {
      const double sign = i % 8 == 0 ? 1 : -1;
      tau = sign * std::pow(10, uniform(-3, 4));
    }
    cases.push_back({{static_cast<S>(curvature), static_cast<S>(turning)}, static_cast<S>(tau)});
  }
  return cases;
}

/// The smaller of x and 1 - x, by bisection over ln(x/(1 - x)).
template <class S>
long double smaller_fraction(const IhypCase<S>& c) {
  const auto G = static_cast<long double>(c.shape.curvature);
  const auto z = static_cast<long double>(c.shape.turning);
  const auto tau = static_cast<long double>(c.tau);
  long double low = -40;
  long double high = 40;
  for (int i = 0; i < 80; ++i) {
    const long double middle = (low + high) / 2;
    const long double x = 1 / (1 + std::exp(-middle));
    const long double y = 1 / (1 + std::exp(middle));
    const long double u = x - z;
    (x + G * u * u * u / (x * y) < tau ? low : high) = middle;
  }
  return 1 / (1 + std::exp(std::abs(low)));
}

template <class S>
double worst_relative_error(Split<S> (*inverse)(const IhypShape<S>&, S)) {
  static const std::vector<IhypCase<S>> cases = whole_ihyp_range<S>(20000);
  static const std::vector<long double> truth = [] {
    std::vector<long double> all;
    all.reserve(cases.size());
    for (const IhypCase<S>& c : cases) {
      all.push_back(smaller_fraction(c));
    }
    return all;
  }();
  long double worst = 0;
  for (std::size_t i = 0; i < cases.size(); ++i) {
    const Split<S> x = inverse(cases[i].shape, cases[i].tau);
    const auto smaller = static_cast<long double>(std::min(x.converted, x.remaining));
    const long double error = std::abs(smaller - truth[i]) / truth[i];
    worst = error <= worst ? worst : error;
  }
  return static_cast<double>(worst);
}

}  // namespace smaservo::benchmarks
