#pragma once
// What the makers of the presets' wires print beside what a wire file has. Sources: README.md.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "model/wire/wire.hpp"

namespace smaservo::choose {

/// How many cycles a wire has to live.
enum class Life : unsigned char {
  many,  ///< "long": the force and the stroke that the maker suggests
  few,   ///< "short": the maker's greatest force and stroke
};

/// The life with this name. Throws UserError.
Life life_of(std::string_view name);

/// One wire of the makers' tables. Forces are those of one wire.
struct MakersWire {
  std::string preset;
  Wire<double> wire;         ///< as the preset has it, with its length of 100 mm
  double suggested_load_N;   ///< contracts against it for many cycles
  double stretching_load_N;  ///< stretches the cold wire again
  /// The maker's approximate current that contracts the wire in a second, in still air, and the
  /// time in which it then stretches again but for the last half per cent.
  std::optional<double> current_1s_A, cooling_s;

  double allowed_load_N(Life life) const;
  /// As a share of the length. A bias spring costs a part of Flexinol's.
  double allowed_stroke(Life life, bool spring) const;
  /// What the maker says of the number of cycles under that load and stroke. SmartFlex's prints no
  /// number.
  std::string_view cycles(Life life) const;

 private:
  bool is_flexinol() const { return preset.starts_with("flexinol"); }
};

/// All wires of the makers' tables, in the order of their presets' names.
const std::vector<MakersWire>& makers_wires();

}  // namespace smaservo::choose
