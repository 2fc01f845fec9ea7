#pragma once
// The keys of a wire file, described once: reading, range checks, writing and the list in
// model/wires/README.md all come from this table.

#include <functional>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "model/units.hpp"
#include "model/wire/wire.hpp"

namespace smaservo {

/// One value as it stands in a description, converted to SI.
struct WireEntry {
  std::vector<double> numbers;  ///< one, or the coefficients of a polynomial in the stress
  std::string word;             ///< of a choice
  std::string where;            ///< "FILE:LINE: KEY = VALUE", for error messages
};

/// A description: entries by the path of their field.
using WireEntries = std::map<std::string, WireEntry, std::less<>>;

enum class WireFieldType : unsigned char { number, polynomial, choice };

struct WireField {
  std::string path;  ///< "wire.length": table and name without unit
  WireFieldType type;
  Kind kind;                                  ///< of a number, or of a polynomial's value
  double low, high;                           ///< SI, inclusive; of a polynomial's value at 0 Pa
  std::size_t coefficients;                   ///< of a polynomial, at most
  std::span<const std::string_view> choices;  ///< of a choice
  bool required;
  std::string meaning;
};

/// All fields, in the order of a file.
const std::vector<WireField>& wire_fields();

/// Units of polynomials: "degC_by_MPa" is a value in °C with coefficients per MPa, per MPa², ...
struct PolynomialUnit {
  std::string suffix;
  Unit value;
  double stress_Pa;
};
std::vector<PolynomialUnit> polynomial_units(const WireField& field);

/// Builds the wire. `fail(path, reason)` is called for what is missing or contradictory, and does
/// not return.
Wire<double> build_wire(
    const WireEntries& entries,
    const std::function<void(std::string_view path, const std::string& reason)>& fail);

/// The entries that build this wire.
WireEntries describe_wire(const Wire<double>& wire);

}  // namespace smaservo
