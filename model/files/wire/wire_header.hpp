#pragma once
// A wire as a C++ header, for programs that read no files: a microcontroller's.

#include <string>

#include "model/files/wire/wire_file.hpp"

namespace smaservo::files {

/// A header with one function template that returns the wire, to the same bits in double:
///   template <class S> smaservo::Wire<S> wire_smartflex_76um();
/// Its name is the description's, with an underscore for what no C++ name may have: give wires of
/// one program names that differ in letters or digits. The header
/// needs the headers of the installed library and nothing else.
std::string to_header(const WireDescription& description);

}  // namespace smaservo::files
