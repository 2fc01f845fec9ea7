#pragma once
// The interface of every model of the phase transformation: temperature and stress in, phase
// fractions out; the history is in a small state, and there is no time.

#include <concepts>
#include <type_traits>

namespace smaservo {

/// What drives the transformation.
template <class S>
struct Drive {
  S temperature_K;
  S stress_Pa;  ///< tension is positive
};

/// Phase fractions, each in 0..1; austenite is the rest.
template <class S>
struct Phases {
  S martensite;
  S r_phase;

  /// The rest: 1 less the other two.
  constexpr S austenite() const { return S(1) - martensite - r_phase; }
};

/// The direction of the transformation: towards austenite or towards martensite.
enum class Heading : unsigned char { heating, cooling };

/// Change of the phase fractions per kelvin of rising temperature.
template <class S>
struct PhaseRates {
  S martensite_1_K;
  S r_phase_1_K;
};

/// A hysteresis model. State is a small value, trivially copyable if its scalar is; a step changes
/// it in place, because most of its bytes stay as they are. Properties, tested once for all models
/// in tests/model/kinetics_suite.hpp: the fractions stay on the simplex (none negative, the sum of
/// all three 1); an unchanged drive changes nothing, to the bit; one big step equals many small
/// ones within a bound that each model states; a full cycle erases history.
template <class K>
concept Kinetics =
    (std::is_trivially_copyable_v<typename K::State> ||
     !std::is_trivially_copyable_v<typename K::Scalar>) &&
    requires(const typename K::Params& params, const typename K::State& state,
             typename K::State& moving, const Drive<typename K::Scalar>& drive, Heading heading) {
      /// The state of a wire that was cooled to this temperature at this stress from far above.
      { K::rest(params, drive) } -> std::same_as<typename K::State>;
      /// Moves the state to a new drive.
      { K::advance(params, moving, drive) } -> std::same_as<void>;
      { K::drive(state) } -> std::same_as<Drive<typename K::Scalar>>;
      { K::phases(state) } -> std::same_as<Phases<typename K::Scalar>>;
      /// Slopes at the state for a small step in this heading at constant stress.
      { K::rates(params, state, heading) } -> std::same_as<PhaseRates<typename K::Scalar>>;
    };

/// A model with rates of its own, which also moves at a constant drive. Its `advance` without a
/// time jumps to the drive and rests there for a time that is long for the model.
template <class K>
concept TimedKinetics =
    Kinetics<K> && requires(const typename K::Params& params, typename K::State& moving,
                            const Drive<typename K::Scalar>& drive, typename K::Scalar dt_s) {
      { K::advance(params, moving, drive, dt_s) } -> std::same_as<void>;
    };

}  // namespace smaservo
