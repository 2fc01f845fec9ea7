#pragma once
// Resistivities of two phases that are curved over temperature; the phases conduct in parallel.
// Source: paper 001 section V, eq. 20 to 23.

#include <cmath>
#include <cstddef>

#include "model/units.hpp"

namespace smaservo::papers {

template <class S>
struct DuhemResistivity {
  S austenite_ohm_m;         ///< p_1
  S austenite_cold_ohm_m;    ///< p_2, additional resistivity at the ambient temperature
  S austenite_decay_1_K;     ///< p_3
  S step_ohm_m;              ///< q_1, height of martensite's step at 0 °C
  S step_ohm_m_K;            ///< q_2
  S step_centre_K;           ///< m_3
  S step_width_K;            ///< n_3
  S martensite_ohm_m_K[10];  ///< α_0 ... α_9, by power of the temperature above ambient
  S lowest_K, highest_K;     ///< range in which the polynomial was fitted; outside, it diverges

  constexpr bool valid(const S& temperature_K) const {
    return !(temperature_K < lowest_K) && !(highest_K < temperature_K);
  }

  S austenite(const S& temperature_K, const S& ambient_K) const {
    using std::exp;
    // 001 eq. 22
    return austenite_ohm_m +
           austenite_cold_ohm_m * exp(-austenite_decay_1_K * (temperature_K - ambient_K));
  }

  S martensite(const S& temperature_K, const S& ambient_K) const {
    using std::erf;
    const S above = temperature_K - ambient_K;
    S sum = S(0);
    for (std::size_t power = 10; power-- > 0;) {
      sum = sum * above + martensite_ohm_m_K[power];
    }
    // 001 eq. 23; its temperature is in °C
    return (step_ohm_m - step_ohm_m_K * (temperature_K - S(zero_degC_K))) *
               (S(1) + erf((temperature_K - step_centre_K) / step_width_K)) +
           sum;
  }

  /// The resistivity of the mixture.
  S parallel(const S& martensite_fraction, const S& temperature_K, const S& ambient_K) const {
    // 001 eq. 21
    return S(1) / ((S(1) - martensite_fraction) / austenite(temperature_K, ambient_K) +
                   martensite_fraction / martensite(temperature_K, ambient_K));
  }
};

}  // namespace smaservo::papers
