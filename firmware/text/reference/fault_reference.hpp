#pragma once
// What is known of every fault, for people: the reference page and `host-sim explain`.

#include <string>
#include <string_view>
#include <vector>

#include "firmware/faults.hpp"

namespace smaservo::text {

/// firmware/reference/FAULTS.md, made from the table of faults.
std::string fault_reference();

/// One fault as plain text, some lines.
std::string explain_fault(Fault fault);

/// A fault by its name, or by its code: "2310h", "0x2310", or decimal "8976". Fault::none where
/// there is none such.
Fault find_fault(std::string_view name_or_code);

/// Names that are much like this one, the closest first; at most three.
std::vector<std::string> similar_faults(std::string_view name);

}  // namespace smaservo::text
