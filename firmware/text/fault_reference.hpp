#pragma once
// Descriptions of the faults for people: the reference page, and the texts of `host-sim explain`.

#include <string>
#include <string_view>
#include <vector>

#include "firmware/faults.hpp"

namespace smaservo::text {

/// firmware/reference/FAULTS.md, made from the table of faults.
std::string fault_reference();

/// Explains one fault in some lines of plain text.
std::string explain_fault(Fault fault);

/// Finds a fault by its name or its code: "2310h", "0x2310", or decimal "8976". Fault::none where
/// there is no such fault.
Fault find_fault(std::string_view name_or_code);

/// At most three names of faults that are similar to this one, the closest first.
std::vector<std::string> similar_faults(std::string_view name);

}  // namespace smaservo::text
