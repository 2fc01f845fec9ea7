#pragma once
// The covariance of the Kalman filter's states, and what a step of the filter does to it:
//     prediction   P <- F P Fᵀ + Q
//     correction   P <- P - K (P H)ᵀ
// F is the derivative of the states after a step by those before it, Q the variance that the step
// adds, H the derivative of the measured resistance by the states, and K the filter's gain. These
// are the textbook's equations of an extended Kalman filter; no paper here has them.

#include <Eigen/Core>
#include <cstddef>
#include <type_traits>

#include "model/scalar/scalar.hpp"

namespace smaservo {

/// The filter's states: temperature, martensite and R-phase of the wire's middle; slowly varying:
/// ambient temperature, a factor on the heat loss, a factor on the resistance.
struct FilterStates {
  enum Index { iT, iM, iR, iAmbient, iLoss, iResistance, size };
};

/// Symmetric; both halves are kept. A Covariance{} is zero.
///
/// Where there are vector registers a row is computed at once; it is padded to whole registers, and
/// the padding stays zero. Elsewhere each pair of equal elements is computed once.
template <class S>
class Covariance : FilterStates {
  static constexpr bool has_vectors = EIGEN_MAX_STATIC_ALIGN_BYTES > 0;
  static constexpr int width = has_vectors && sizeof(S) == sizeof(float) ? 8 : size;

 public:
  using Vector = Eigen::Matrix<S, 1, width>;

  /// The derivatives of a phase after a step by the states before it, at a given temperature after
  /// the step.
  struct Phase {
    S by_martensite, by_r_phase, by_temperature;
  };
  /// F as the product B G of two matrices. G gives the temperature after the step, and the phases
  /// as if that temperature did not move them; B then adds the change of the phases with the
  /// temperature. The slow states stay unchanged.
  struct Transition {
    const Vector& temperature;  ///< first row of G; its element for the resistance's factor is zero
    Phase martensite, r_phase;  ///< second and third row of G
    S martensite_1_K, r_phase_1_K;  ///< what B adds to the phases per kelvin
  };

  S& at(int i, int j) { return elements_[i][j]; }
  const S& at(int i, int j) const { return elements_[i][j]; }
  auto row(int i) const { return Row<const Vector>(elements_[i]); }

  /// P <- B (G P Gᵀ + Q_T) Bᵀ. Q_T is the noise of the temperature alone, which moves the phases,
  /// too. The caller adds the noise of the other states to their at(i, i) afterwards.
  [[gnu::always_inline]] void propagate(const Transition& f, const S& temperature_noise_K2);

  /// P H. The resistance does not depend on the factor on the loss: that element of H is zero.
  Vector times(const Vector& H) const {
    return sum_of_rows<iT, iM, iR, iAmbient, iResistance>(H[iT], H[iM], H[iR], H[iAmbient],
                                                          H[iResistance]);
  }
  /// Hᵀ (P H), the variance of the expected resistance due to the states.
  static S variance(const Vector& H, const Vector& PH) {
    return dot<iT, iM, iR, iAmbient, iResistance>(H, PH);
  }
  /// P <- P - K (P H)ᵀ
  [[gnu::always_inline]] void update(const Vector& K, const Vector& PH);

 private:
  static constexpr bool by_rows = has_vectors && std::is_floating_point_v<S>;

  template <class V>
  using Row = Eigen::Map<V, has_vectors ? Eigen::Aligned16 : Eigen::Unaligned>;
  Row<Vector> own_row(int i) { return Row<Vector>(elements_[i]); }

  /// Σ factor · row
  template <int... rows, class... Factors>
  Vector sum_of_rows(const Factors&... factors) const {
    if constexpr (by_rows) {
      return (... + (factors * row(rows)));
    } else {
      Vector sum;
      for (int j = 0; j < size; ++j) {
        sum[j] = sum_of_products(Product<S>{factors, at(rows, j)}...);
      }
      return sum;
    }
  }
  /// The scalar product over these elements; all other elements of a or b are zero.
  template <int... elements>
  static S dot(const Vector& a, const Vector& b) {
    if constexpr (by_rows) {
      return a.dot(b);
    } else {
      return sum_of_products(Product<S>{a[elements], b[elements]}...);
    }
  }
  Vector row_of(const Phase& g) const {
    return sum_of_rows<iM, iR, iT>(g.by_martensite, g.by_r_phase, g.by_temperature);
  }
  static S along(const Phase& g, const Vector& v) {
    return sum_of_products(Product<S>{g.by_martensite, v[iM]}, Product<S>{g.by_r_phase, v[iR]},
                           Product<S>{g.by_temperature, v[iT]});
  }
  /// Writes the rows and columns of T, M and R, except for the nine elements between these three.
  [[gnu::always_inline]] void put_rows(const Transition& f, const Vector& T, const Vector& M,
                                       const Vector& R);
  void put(int i, int j, const S& x) { elements_[i][j] = elements_[j][i] = x; }

  alignas(16) S elements_[std::size_t{size}][std::size_t{width}];
};

template <class S>
inline void Covariance<S>::propagate(const Transition& f, const S& temperature_noise_K2) {
  using Term = Product<S>;
  const Vector& g = f.temperature;
  // G P: the rows of P that G changes
  const Vector T =
      sum_of_rows<iT, iM, iR, iAmbient, iLoss>(g[iT], g[iM], g[iR], g[iAmbient], g[iLoss]);
  const Vector M = row_of(f.martensite);
  const Vector R = row_of(f.r_phase);
  // G P Gᵀ + Q_T, and from it by B the elements of P; the covariances of T with M and R are needed
  // before and after B.
  const S TT = dot<iT, iM, iR, iAmbient, iLoss>(g, T) + temperature_noise_K2;
  const S given_TM = along(f.martensite, T);
  const S given_TR = along(f.r_phase, T);
  const S TM = sum_of_products(given_TM, Term{f.martensite_1_K, TT});
  const S TR = sum_of_products(given_TR, Term{f.r_phase_1_K, TT});
  const S MM = sum_of_products(along(f.martensite, M), Term{f.martensite_1_K, given_TM + TM});
  const S MR = sum_of_products(along(f.r_phase, M), Term{f.martensite_1_K, given_TR},
                               Term{f.r_phase_1_K, TM});
  const S RR = sum_of_products(along(f.r_phase, R), Term{f.r_phase_1_K, given_TR + TR});
  put_rows(f, T, M, R);
  put(iT, iT, TT);
  put(iT, iM, TM);
  put(iT, iR, TR);
  put(iM, iM, MM);
  put(iM, iR, MR);
  put(iR, iR, RR);
}

template <class S>
inline void Covariance<S>::put_rows(const Transition& f, const Vector& T, const Vector& M,
                                    const Vector& R) {
  if constexpr (by_rows) {
    own_row(iT) = T;
    own_row(iM) = M + f.martensite_1_K * T;
    own_row(iR) = R + f.r_phase_1_K * T;
  } else {
    for (int j = iAmbient; j < size; ++j) {
      at(iT, j) = T[j];
      at(iM, j) = sum_of_products(M[j], Product<S>{f.martensite_1_K, T[j]});
      at(iR, j) = sum_of_products(R[j], Product<S>{f.r_phase_1_K, T[j]});
    }
  }
  for (int j = iAmbient; j < size; ++j) {
    at(j, iT) = at(iT, j);
    at(j, iM) = at(iM, j);
    at(j, iR) = at(iR, j);
  }
}

template <class S>
inline void Covariance<S>::update(const Vector& K, const Vector& PH) {
  if constexpr (by_rows) {
    for (int i = 0; i < size; ++i) {
      own_row(i) -= K[i] * PH;
    }
  } else {
    for (int i = 0; i < size; ++i) {
      const S less = -K[i];
      for (int j = i; j < size; ++j) {
        put(i, j, sum_of_products(at(i, j), Product<S>{less, PH[j]}));
      }
    }
  }
}

}  // namespace smaservo
