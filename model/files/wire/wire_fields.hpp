#pragma once
// The keys of a wire file, which are those of [wire] in a settings file: the rows of
// model/wire/wire_parameters.hpp, and what only files say in another way. Reading, writing and the
// list in model/wires/README.md come from them.

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

/// How a value of this type stands in a file.
FieldType field_type(ValueType type);

/// Whether a file must have it, by this key or by another one of its slot.
bool is_needed(const Field& field);

/// The keys that a description of this wire has.
std::vector<const Field*> written_fields(const Wire<double>& wire);

/// What one of them says of it, in SI.
std::vector<double> wire_numbers(const Field& field, const Wire<double>& wire);

/// Is called with the path of a key or of a process, and does not return.
using WireFailure = std::function<void(std::string_view path, const std::string& reason)>;

/// Builds the wire. Calls `fail` for what is missing.
Wire<double> build_wire(const Entries& entries, const WireFailure& fail);

/// Calls `fail` for what contradicts itself.
void check_wire(const Wire<double>& wire, const WireFailure& fail);

/// What `fail` speaks of: where the key stands, or the key.
std::string where_said(const Entries& entries, const std::string& origin, std::string_view path);

/// Entries that build this wire to the same bits, each number by itself.
Entries describe_wire(const Wire<double>& wire);

}  // namespace smaservo::files
