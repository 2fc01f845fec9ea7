#pragma once
// The model in automatic differentiation: by the filter's states before a step, and by the
// temperature after it.

#include <ceres/jet.h>
#include <limits>

#include "observer/kalman.hpp"

namespace smaservo {

// Derivatives by the filter's states before a step and by the temperature after it.
constexpr int iAfter = KalmanObserver<double>::size;

/// ceres::Jet, made from plain numbers without being asked: the model's Pair<S>(1) wants that.
struct Jet : ceres::Jet<double, iAfter + 1> {
  using Base = ceres::Jet<double, iAfter + 1>;
  Jet() = default;
  Jet(const Base& jet) : Base(jet) {}
  Jet(double number) : Base(number) {}
  Jet(double number, int by) : Base(number, by) {}
  const Base& base() const { return *this; }
  friend Jet operator+(const Jet& x, const Jet& y) { return x.base() + y.base(); }
  friend Jet operator-(const Jet& x, const Jet& y) { return x.base() - y.base(); }
  friend Jet operator-(const Jet& x) { return -x.base(); }
  friend Jet operator*(const Jet& x, const Jet& y) { return x.base() * y.base(); }
  friend Jet operator/(const Jet& x, const Jet& y) { return x.base() / y.base(); }
  friend bool operator<(const Jet& x, const Jet& y) { return x.a < y.a; }
};

}  // namespace smaservo

template <>
struct std::numeric_limits<smaservo::Jet> : std::numeric_limits<double> {};

namespace smaservo {

using JK = ThreePhase<Jet>;
using K = ThreePhase<double>;

inline Surface<Jet> to_jet(const Surface<double>& s) {
  return convert_surface<Jet>(s, [](double x) { return Jet(x); });
}

inline JK::Params to_jet(const K::Params& p) {
  JK::Params to;
  to.m2a = to_jet(p.m2a);
  to.a2m_a2r = pair_surfaces(to_jet(first_surface(p.a2m_a2r)), to_jet(second_surface(p.a2m_a2r)));
  to.r2a = to_jet(p.r2a);
  to.r2m = to_jet(p.r2m);
  to.separate_r2a = p.separate_r2a;
  to.separate_r2m = p.separate_r2m;
  to.memory = p.memory;
  to.smallest_reversal_K = p.smallest_reversal_K;
  to.loop_odds = p.loop_odds;
  return to;
}

inline Phase<Jet> to_jet(const Phase<double>& p) {
  return {Jet(p.strain), Jet(p.modulus_Pa), Jet(p.resistivity_ohm_m), Jet(p.resistivity_ohm_m_K),
          Jet(p.resistivity_ohm_m_Pa)};
}

inline Material<Jet> to_jet(const Material<double>& m) {
  return {to_jet(m.martensite), to_jet(m.r_phase), to_jet(m.austenite), m.reference_K, m.mixture};
}

inline JK::HotTurn to_jet(const K::HotTurn& t) {
  return {{Jet(t.left.m2a), Jet(t.left.r2a)}, Jet(t.martensite), Jet(t.r_phase)};
}
inline JK::ColdTurn to_jet(const K::ColdTurn& t) {
  return {{Pair<Jet>(Jet(t.left.a2m_a2r.first()), Jet(t.left.a2m_a2r.second())), Jet(t.left.r2m)},
          Jet(t.austenite),
          Jet(t.r_phase),
          Jet(t.returning)};
}

template <class To, class Points>
To to_jet_points(Points points) {
  To to;
  to.start(to_jet(Points().newest()));
  for (const auto& turn : points) {
    to.push(to_jet(turn));
  }
  return to;
}

inline JK::State to_jet(const K::State& s) {
  JK::State to;
  to.drive = {Jet(s.drive.temperature_K), Jet(s.drive.stress_Pa)};
  to.reached = {Jet(s.reached.temperature_K), Jet(s.reached.stress_Pa)};
  to.martensite = Jet(s.martensite);
  to.r_phase = Jet(s.r_phase);
  to.returning = Jet(s.returning);
  to.reverse = {Jet(s.reverse.m2a), Jet(s.reverse.r2a)};
  to.forward = {Pair<Jet>(Jet(s.forward.a2m_a2r.first()), Jet(s.forward.a2m_a2r.second())),
                Jet(s.forward.r2m)};
  to.heading = s.heading;
  to.hot = to_jet_points<decltype(to.hot)>(s.hot);
  to.cold = to_jet_points<decltype(to.cold)>(s.cold);
  return to;
}

}  // namespace smaservo
