#pragma once
// What a column of somebody else's file probably is, by its name and unit: `I [mA]`, `Spannung/V`,
// `Force (N)`, `load_g`.

#include <optional>
#include <string>
#include <string_view>

namespace smaservo::hal {

/// A quantity that the reader understands, and the unit that the name tells.
struct Meaning {
  std::string_view base;  ///< "current"
  std::string_view unit;  ///< as in the reader's own names: "mA"; empty: the name has no unit
  double scale = 1;       ///< of a value in the file, to have it in `unit`
  std::string written;    ///< the unit as in the file
  /// Why the name does not tell enough to take the column; empty: it does.
  std::string_view doubt;
};

/// The meaning of a name, regardless of case, blanks and underscores; none unless the whole name is
/// understood.
std::optional<Meaning> meaning_of(std::string_view name);

/// Whether the text is a unit or nothing, also in brackets: a field of a row of units.
bool is_unit_field(std::string_view text);

}  // namespace smaservo::hal
