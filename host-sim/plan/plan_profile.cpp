#include "host-sim/plan/plan_profile.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace smaservo::plan {
namespace {

double uniform(std::mt19937_64& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

int whole(std::mt19937_64& random, int low, int high) {
  return std::uniform_int_distribution<int>(low, high)(random);
}

/// Straight up in the first half of u = 0..1 and down in the second, with holds if ramp < 1.
double trapezoid(double u, double ramp) {
  const double up = u < 0.5 ? 2 * u : 2 - 2 * u;
  const double rise = u < 0.5 ? up / ramp : 1 - (1 - up) / ramp;
  return std::clamp(rise, 0.0, 1.0);
}

using Part = std::vector<double>;

Part full_cycles(const Recipe& r, std::size_t steps) {
  double all = 0;
  for (int i = 0; i < r.cycles; ++i) {
    all += std::pow(r.pace, i);
  }
  Part part;
  for (std::size_t i = 0; i < steps; ++i) {
    double at = all * static_cast<double>(i) / static_cast<double>(steps);
    double length = 1;
    for (int cycle = 1; cycle < r.cycles && at >= length; ++cycle) {
      at -= length;
      length *= r.pace;
    }
    part.push_back(trapezoid(std::min(at / length, 1.0), r.ramp));
  }
  return part;
}

Part stairs(const Recipe& r, std::size_t steps) {
  Part part;
  for (std::size_t i = 0; i < steps; ++i) {
    const double u = static_cast<double>(i) / static_cast<double>(steps);
    const int step = static_cast<int>(u * 2 * r.stairs);
    const int height = step < r.stairs ? step + 1 : 2 * r.stairs - step - 1;
    part.push_back(r.low + (1 - r.low) * height / r.stairs);
  }
  return part;
}

Part shrinking_loops(const Recipe& r, std::size_t steps) {
  const double reach = std::min(r.center - r.low, 1 - r.center);
  Part part;
  for (std::size_t i = 0; i < steps; ++i) {
    const double at = r.loops * static_cast<double>(i) / static_cast<double>(steps);
    const double amplitude = reach * std::pow(5.0 / 6, std::floor(at));
    part.push_back(r.center + amplitude * (2 * trapezoid(at - std::floor(at), 0.8) - 1));
  }
  return part;
}

Part random_holds(const Recipe& r, std::size_t steps) {
  std::mt19937_64 random(r.seed);
  std::vector<double> level;
  std::vector<double> end;
  for (int i = 0; i < r.holds; ++i) {
    level.push_back(uniform(random, r.low, 1));
    end.push_back((end.empty() ? 0 : end.back()) + uniform(random, 0.4, 1.6));
  }
  Part part;
  std::size_t at = 0;
  for (std::size_t i = 0; i < steps; ++i) {
    const double now = end.back() * static_cast<double>(i) / static_cast<double>(steps);
    while (now >= end[at]) {
      ++at;
    }
    part.push_back(level[at]);
  }
  return part;
}

}  // namespace

Recipe random_recipe(std::mt19937_64& random) {
  Recipe r;
  for (double& share : r.shares) {
    // Some parts get the share 0 and are left out.
    share = std::max(0.0, uniform(random, -0.3, 1));
  }
  r.shares[0] = std::max(r.shares[0], 0.3);
  r.cycles = whole(random, 1, 5);
  r.pace = uniform(random, 0.4, 1);
  r.ramp = uniform(random, 0.2, 1);
  r.low = uniform(random, 0, 0.5);
  r.stairs = whole(random, 3, 12);
  r.loops = whole(random, 3, 12);
  r.center = uniform(random, r.low + 0.1, 0.9);
  r.holds = whole(random, 6, 40);
  r.seed = random();
  return r;
}

Recipe varied(const Recipe& recipe, std::mt19937_64& random) {
  Recipe r = recipe;
  const Recipe other = random_recipe(random);
  const auto now = [&] { return uniform(random, 0, 1) < 0.3; };
  for (double& share : r.shares) {
    share = now() ? std::max(0.0, share + uniform(random, -0.3, 0.3)) : share;
  }
  r.shares[0] = std::max(r.shares[0], 0.1);
  r.cycles = now() ? other.cycles : r.cycles;
  r.pace = now() ? other.pace : r.pace;
  r.ramp = now() ? other.ramp : r.ramp;
  r.stairs = now() ? other.stairs : r.stairs;
  r.loops = now() ? other.loops : r.loops;
  if (now()) {
    r.low = other.low;
    r.center = other.center;
  }
  r.holds = now() ? other.holds : r.holds;
  r.seed = now() ? other.seed : r.seed;
  return r;
}

std::vector<double> levels(const Recipe& r, std::size_t steps) {
  const std::size_t rest = steps / 50 + 1;
  const double driven = static_cast<double>(steps - std::min(steps, 2 * rest));
  const double all = std::accumulate(r.shares.begin(), r.shares.end(), 0.0);
  std::vector<double> profile(rest, 0.0);
  constexpr Part (*parts[])(const Recipe&, std::size_t) = {full_cycles, stairs, shrinking_loops,
                                                           random_holds};
  double share = 0;
  std::size_t done = 0;
  for (std::size_t i = 0; i < r.shares.size(); ++i) {
    share += r.shares[i] / all;
    const auto end = static_cast<std::size_t>(std::min(share, 1.0) * driven);
    const Part part = parts[i](r, end - done);
    profile.insert(profile.end(), part.begin(), part.end());
    done = end;
  }
  profile.resize(steps, 0.0);
  for (double& level : profile) {
    level = std::clamp(level, 0.0, 1.0);
  }
  return profile;
}

}  // namespace smaservo::plan
