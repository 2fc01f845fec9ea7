#pragma once
// Every number of a wire, described once and without heap: path with its SI unit, range, meaning,
// and its place in a Wire. Wire files, a device's parameters and their CAN objects are derived from
// this table; firmware/parameters adds the keys, in the order of the rows.

#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <string_view>
#include <type_traits>
#include <utility>

#include "model/units.hpp"
#include "model/wire/wire.hpp"

namespace smaservo {

/// A path made of up to three parts, such as "strain" + ".proportional_" + "W".
class Path {
 public:
  constexpr Path() = default;
  // NOLINTNEXTLINE(google-explicit-constructor)
  constexpr Path(const char* a, const char* b = "", const char* c = "") {
    for (const std::string_view part : {a, b, c}) {
      for (const char letter : part) {
        text_[size_++] = letter;  // A path that is too long does not compile.
      }
    }
  }
  constexpr std::string_view text() const { return {text_.data(), size_}; }

 private:
  std::array<char, 48> text_{};
  std::size_t size_ = 0;
};

/// Concatenates arrays.
template <class T, std::size_t... n>
constexpr auto joined(const std::array<T, n>&... parts) {
  std::array<T, (n + ...)> all{};
  std::size_t at = 0;
  const auto append = [&](const auto& part) {
    for (const T& item : part) {
      all[at++] = item;
    }
  };
  (append(parts), ...);
  return all;
}

/// These numbers stand in a device's stored image: never change one.
enum class ValueType : std::uint8_t {
  real = 0,     ///< REAL32
  number = 1,   ///< UNSIGNED32
  choice = 2,   ///< UNSIGNED8, one of some names
  boolean = 3,  ///< BOOLEAN
};

/// The surface without which a parameter has no meaning.
enum class Needs : std::uint8_t { nothing, own_r2a, own_r2m };

template <class S>
constexpr bool is_used(Needs needs, const Wire<S>& wire) {
  const ThreePhaseParams<S>& k = wire.kinetics;
  return needs == Needs::nothing || (needs == Needs::own_r2a ? k.separate_r2a : k.separate_r2m);
}

/// The lane of the Pair that a real is part of.
enum class Lane : std::uint8_t { none, first, second };

/// Reads a real that may be part of a pair.
template <class S>
S load_real(const void* from, Lane lane) {
  if (lane == Lane::none) {
    return *static_cast<const S*>(from);
  }
  const Pair<S>& both = *static_cast<const Pair<S>*>(from);
  return lane == Lane::first ? both.first() : both.second();
}
template <class S>
void keep_real(void* to, Lane lane, const S& value) {
  if (lane == Lane::none) {
    *static_cast<S*>(to) = value;
    return;
  }
  Pair<S>& both = *static_cast<Pair<S>*>(to);
  both = lane == Lane::first ? Pair<S>(value, both.second()) : Pair<S>(both.first(), value);
}

/// Reads a number of 32 bits, an enumerator of 8, or a bool.
inline std::uint32_t load_whole(const void* from, ValueType type) {
  return type == ValueType::number   ? *static_cast<const std::uint32_t*>(from)
         : type == ValueType::choice ? *static_cast<const std::uint8_t*>(from)
                                     : std::uint32_t{*static_cast<const bool*>(from)};
}
inline void keep_whole(void* to, ValueType type, std::uint32_t value) {
  if (type == ValueType::number) {
    *static_cast<std::uint32_t*>(to) = value;
  } else if (type == ValueType::choice) {
    *static_cast<std::uint8_t*>(to) = static_cast<std::uint8_t>(value);
  } else {
    *static_cast<bool*>(to) = value != 0;
  }
}

template <class S>
struct WireParameter {
  Path path;  ///< table and name, with the SI unit as suffix
  ValueType type;
  Kind kind;                                  ///< unit kind of a real
  double min, max;                            ///< range of a real, inclusive
  std::span<const std::string_view> choices;  ///< names of a choice, by value
  std::string_view meaning;
  const void* (*at)(const Wire<S>&);  ///< address of the value, for load_real() and load_whole()
  Needs needs = Needs::nothing;
  Lane lane = Lane::none;
  /// The number of rows of a polynomial; stands in the row of its constant.
  std::uint8_t coefficients = 1;
  /// The default if a wire file leaves it out; NaN: the file needs it, or it follows from others.
  double standard = std::numeric_limits<double>::quiet_NaN();
  // NOLINTNEXTLINE(readability-redundant-member-init): for designated initializers
  std::string_view follows = {};  ///< how the default follows from others, in words
  /// A device that has never been given this number uses the default. The default alone does not
  /// make its wire configured.
  bool default_in_devices = false;

  constexpr WireParameter with_default(double value) const {
    WireParameter row = *this;
    row.standard = value;
    return row;
  }
  constexpr WireParameter with_default_in_devices(double value) const {
    WireParameter row = with_default(value);
    row.default_in_devices = true;
    return row;
  }
  constexpr WireParameter following(std::string_view words) const {
    WireParameter row = *this;
    row.follows = words;
    return row;
  }

  constexpr bool is_used(const Wire<S>& wire) const { return smaservo::is_used(needs, wire); }
  /// The value; a choice as its index, a boolean as 0 or 1.
  double get(const Wire<S>& wire) const {
    return type == ValueType::real ? static_cast<double>(load_real<S>(at(wire), lane))
                                   : load_whole(at(wire), type);
  }
  void set(Wire<S>& wire, double value) const {
    void* to = const_cast<void*>(at(wire));  // NOLINT(*-const-cast)
    if (type == ValueType::real) {
      keep_real(to, lane, S(value));
    } else {
      keep_whole(to, type, static_cast<std::uint32_t>(value));
    }
  }
};

inline constexpr std::string_view memory_names[] = {"plain", "return-point"};
inline constexpr std::string_view mixture_names[] = {"series", "parallel"};

/// The rows for one scalar, in groups by table.
template <class S>
struct WireRows {
  using Row = WireParameter<S>;
  using W = Wire<S>;
  using G = Geometry<S>;
  using K = ThreePhaseParams<S>;
  using M = Material<S>;
  using H = HeatParams<S>;
  using A = Accuracy<S>;
  using L = Limits<S>;
  using P = Phase<S>;

  template <auto... members>
  static constexpr const void* at(const W& wire) {
    return &(wire.*....*members);
  }
  template <auto... members>
  static constexpr Row real(Path path, Kind kind, double min, double max,
                            std::string_view meaning) {
    static_assert(std::is_same_v<decltype((std::declval<W&>().*....*members)), S&>);
    return {path, ValueType::real, kind, min, max, {}, meaning, at<members...>};
  }
  template <auto... members>
  static constexpr Row choice(Path path, std::span<const std::string_view> choices,
                              std::string_view meaning) {
    return {path, ValueType::choice, kind::count, 0, 0, choices, meaning, at<members...>};
  }
  template <auto... members>
  static constexpr Row flag(Path path, std::string_view meaning) {
    return {path, ValueType::boolean, kind::count, 0, 0, {}, meaning, at<members...>};
  }

  static constexpr auto itself() {
    constexpr auto g = &W::geometry;
    constexpr auto k = &W::kinetics;
    return std::to_array<Row>({
        real<g, &G::length_m>("wire.length_m", kind::length, 1e-3, 100,
                              "length between the clamps"),
        real<g, &G::diameter_m>("wire.diameter_m", kind::length, 5e-6, 5e-3,
                                "diameter of the bare wire"),
        real<&W::nominal_stroke>("wire.nominal_stroke", kind::number, 1e-3, 0.2,
                                 "stroke that errors are given as a share of")
            .with_default(0.04),
        choice<k, &K::memory>(
            "wire.memory", memory_names,
            "whether inner loops end where they began (return-point) or are scaled as in paper 000 "
            "(plain)")
            .with_default(1),
        real<k, &K::smallest_reversal_K>(
            "wire.smallest_reversal_K", kind::temperature_difference, 0, 5,
            "smallest reversal of the temperature that counts as a turning point")
            .following("0.5 with return-point memory, 0 without"),
        flag<k, &K::separate_r2a>("wire.separate_r2a",
                                  "true: R2A has its own surface; false: it has that of M2A")
            .following("true where r2a is given"),
        flag<k, &K::separate_r2m>("wire.separate_r2m",
                                  "true: R2M has its own surface; false: it has that of A2M")
            .following("true where r2m is given"),
        real<k, &K::loop_odds>(
            "wire.loops.odds", kind::number, loop_odds_range.min, loop_odds_range.max,
            "how the order in which the wire's parts become austenite depends on the order in "
            "which they became martensite: 1 not at all, more: the last ones first")
            .with_default_in_devices(1),
    });
  }

  template <auto surface, auto polynomial, std::size_t i>
  static constexpr const void* coefficient(const W& wire) {
    return &(wire.kinetics.*surface.*polynomial)[i];
  }

  template <auto surface>
  static constexpr const void* taper_at(const W& wire) {
    return &(wire.kinetics.*surface).taper;
  }

  /// The eleven numbers of one transformation process, coefficients by power of the stress in Pa;
  /// it has a surface of its own, or is one lane of the pair.
  template <auto surface, Lane lane = Lane::none, Needs needs = Needs::nothing>
  static constexpr auto process(const char* p) {
    using Q = std::remove_cvref_t<decltype(std::declval<K&>().*surface)>;
    const auto row = [](auto at, Path path, Kind kind, double min, double max,
                        std::string_view meaning, std::uint8_t n = 1) {
      const Row r{path, ValueType::real, kind, min, max, {}, meaning, at, needs, lane, n};
      return n == 1 ? r.with_default(0) : r;
    };
    constexpr Kind K0 = kind::temperature;
    constexpr Kind K1 = kind::kelvin_per_stress;
    constexpr Kind K2 = kind::kelvin_per_square_stress;
    constexpr auto c = &Q::curvature;
    constexpr auto z = &Q::turning;
    constexpr auto s = &Q::start_K;
    constexpr auto f = &Q::finish_K;
    return std::to_array<Row>({
        row(coefficient<surface, s, 0>, {p, ".start_0_K"}, K0, 150, 600,
            "start temperature at 0 Pa", 3),
        row(coefficient<surface, s, 1>, {p, ".start_1_K_Pa"}, K1, -1e-5, 1e-5,
            "linear coefficient of the start temperature over stress"),
        row(coefficient<surface, s, 2>, {p, ".start_2_K_Pa2"}, K2, -1e-13, 1e-13,
            "quadratic coefficient of the start temperature over stress"),
        row(coefficient<surface, f, 0>, {p, ".finish_0_K"}, K0, 150, 600,
            "finish temperature at 0 Pa", 3),
        row(coefficient<surface, f, 1>, {p, ".finish_1_K_Pa"}, K1, -1e-5, 1e-5,
            "linear coefficient of the finish temperature over stress"),
        row(coefficient<surface, f, 2>, {p, ".finish_2_K_Pa2"}, K2, -1e-13, 1e-13,
            "quadratic coefficient of the finish temperature over stress"),
        row(coefficient<surface, c, 0>, {p, ".curvature_0"}, kind::number, 1e-3, 30,
            "curvature at 0 Pa", 2),
        row(coefficient<surface, c, 1>, {p, ".curvature_1_1_Pa"}, kind::per_stress, -1e-6, 1e-6,
            "linear coefficient of the curvature over stress"),
        row(coefficient<surface, z, 0>, {p, ".turning_0"}, kind::number, 0.05, 0.95,
            "fraction at the turning point of the curve, at 0 Pa", 2),
        row(coefficient<surface, z, 1>, {p, ".turning_1_1_Pa"}, kind::per_stress, -1e-7, 1e-7,
            "linear coefficient of the fraction at the turning point over stress"),
        row(taper_at<surface>, {p, ".taper"}, kind::number, 0, surface_range.max_taper,
            "how much sooner both ends of the curve are done than in paper 000, 0: not at all")
            .with_default_in_devices(0),
    });
  }

  template <auto phase>
  static constexpr auto phase_rows(const char* p) {
    constexpr auto m = &W::material;
    return std::to_array<Row>({
        real<m, phase, &P::strain>({p, ".strain"}, kind::number, -0.05, 0.2,
                                   "strain without stress"),
        real<m, phase, &P::modulus_Pa>({p, ".modulus_Pa"}, kind::stress, 1e9, 1e12,
                                       "Young's modulus"),
        real<m, phase, &P::resistivity_ohm_m>(
            {p, ".resistivity_ohm_m"}, kind::resistivity, 1e-8, 1e-4,
            "resistivity at wire.material.reference, without stress"),
        real<m, phase, &P::resistivity_ohm_m_K>({p, ".resistivity_temperature_ohm_m_K"},
                                                kind::resistivity_slope, -1e-6, 1e-6,
                                                "slope of the resistivity over temperature"),
        real<m, phase, &P::resistivity_ohm_m_Pa>({p, ".resistivity_stress_ohm_m_Pa"},
                                                 kind::resistivity_per_stress, -1e-12, 1e-12,
                                                 "slope of the resistivity over stress")
            .with_default(0),
    });
  }

  static constexpr auto others() {
    constexpr auto m = &W::material;
    constexpr auto h = &W::heat;
    constexpr auto a = &W::accuracy;
    constexpr auto l = &W::limits;
    return std::to_array<Row>({
        real<m, &M::reference_K>("wire.material.reference_K", kind::temperature, 200, 400,
                                 "temperature at which the resistivities hold"),
        choice<m, &M::mixture>("wire.material.mixture", mixture_names,
                               "how the phases conduct: one after the other or side by side")
            .with_default(0),
        real<h, &H::density_kg_m3>("wire.heat.density_kg_m3", kind::density, 1e3, 2e4,
                                   "density of the alloy"),
        real<h, &H::specific_heat_J_kgK>("wire.heat.specific_heat_J_kgK", kind::specific_heat, 50,
                                         5000, "specific heat without the transformation"),
        real<h, &H::latent_m2a_J_kg>("wire.heat.latent_m2a_J_kg", kind::specific_energy, 0, 1e5,
                                     "latent heat of martensite to austenite"),
        real<h, &H::latent_r2a_J_kg>(
            "wire.heat.latent_r2a_J_kg", kind::specific_energy, 0, 1e5,
            "latent heat of R-phase to austenite, at most latent_m2a; R2M has the difference"),
        real<h, &H::convection_W_m2K>("wire.heat.convection_W_m2K", kind::heat_transfer, 0.1, 1e5,
                                      "heat transfer coefficient at ambient temperature")
            .following("still air"),
        real<h, &H::convection_W_m2K2>("wire.heat.convection_slope_W_m2K2",
                                       kind::heat_transfer_slope, 0, 1e3,
                                       "rise of that coefficient per kelvin above ambient")
            .following("still air"),
        real<h, &H::clamp_conductivity_W_mK>(
            "wire.heat.clamp_conductivity_W_mK", kind::conductivity, 0, 500,
            "thermal conductivity of the wire towards its cold clamps; 0: they take no heat"),
        real<a, &A::strain>(
            "wire.accuracy.strain", kind::number, 1e-5, 0.1,
            "RMS error of the strain that the model tells from power and load alone")
            .with_default(0.002),
        real<a, &A::resistance>(
            "wire.accuracy.resistance", kind::number, 1e-5, 0.1,
            "RMS error of the resistance that the model tells for a given strain, relative")
            .with_default(0.004),
        real<l, &L::current_A>("wire.limits.current_A", kind::current, 1e-4, 100,
                               "the maker's maximum current in still air"),
        real<l, &L::stress_Pa>("wire.limits.stress_Pa", kind::stress, 1e5, 5e9,
                               "the maker's maximum stress"),
        real<l, &L::temperature_K>("wire.limits.temperature_K", kind::temperature, 300, 700,
                                   "maximum temperature of the wire"),
    });
  }

  static constexpr auto all() {
    return joined(
        itself(), process<&K::m2a>("wire.m2a"), process<&K::a2m_a2r, Lane::first>("wire.a2m"),
        process<&K::a2m_a2r, Lane::second>("wire.a2r"),
        process<&K::r2a, Lane::none, Needs::own_r2a>("wire.r2a"),
        process<&K::r2m, Lane::none, Needs::own_r2m>("wire.r2m"),
        phase_rows<&M::martensite>("wire.martensite"), phase_rows<&M::r_phase>("wire.r_phase"),
        phase_rows<&M::austenite>("wire.austenite"), others());
  }
};

template <class S>
inline constexpr auto wire_parameters = WireRows<S>::all();

inline constexpr std::size_t wire_parameter_count = wire_parameters<double>.size();

}  // namespace smaservo
