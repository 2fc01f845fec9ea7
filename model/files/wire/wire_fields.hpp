#pragma once
// The keys of a wire file, which are also those of [wire] in a settings file: the rows of
// model/wire/wire_parameters.hpp, and the notations that only files know. Reading, writing and the
// list in model/wires/README.md use them.

#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "model/files/toml/fields.hpp"
#include "model/wire/wire_parameters.hpp"

namespace smaservo::files {

/// All keys. Slots are the rows of wire_parameters, in whose order they stand; the first key of a
/// slot is the one that is written:
///   a polynomial by a list instead of each coefficient by itself,
///   the greatest load instead of the stress,
///   slopes of a resistivity by the resistivity instead of their own size.
/// One key has a slot of its own behind the rows: the resistance of the whole wire.
const std::vector<Field>& wire_fields();
inline constexpr std::size_t wire_slot_count = wire_parameter_count + 1;

/// The type of field that a value of this type has in a file.
FieldType field_type(ValueType type);

/// Whether a file must give this value, by this key or by another one of the same slot.
bool is_needed(const Field& field);

/// The keys that are written to describe this wire.
std::vector<const Field*> written_fields(const Wire<double>& wire);

/// The numbers of one key for this wire, in SI.
std::vector<double> wire_numbers(const Field& field, const Wire<double>& wire);

/// Called with the path of a key or of a process; must not return.
using WireFailure = std::function<void(std::string_view path, const std::string& reason)>;

/// Builds the wire. Calls `fail` for missing values.
Wire<double> build_wire(const Entries& entries, const WireFailure& fail);

/// Calls `fail` for values that contradict each other.
void check_wire(const Wire<double>& wire, const WireFailure& fail);

/// The place that an error message names: where the key stands, or else the key.
std::string where_said(const Entries& entries, const std::string& origin, std::string_view path);

/// Entries from which build_wire() makes this wire to the same bits, each number by itself.
Entries describe_wire(const Wire<double>& wire);

}  // namespace smaservo::files
