#pragma once
// The description of one fault.

#include <cstdint>
#include <string_view>

#include "firmware/faults.hpp"

namespace smaservo {

enum class Clears : std::uint8_t {
  itself,       ///< the fault ends with its condition; nothing is latched
  command,      ///< ended by the command to clear, after the condition has gone
  acknowledge,  ///< ended by the command to clear, even though the condition remains
  reset,        ///< ended by a restart only
};

struct FaultRow {
  Fault fault;
  FaultClass severity;
  Clears clears;
  std::uint16_t code;  ///< EMCY code of CiA 301, FFxxh if none fits; it never changes
  std::string_view name;
  double deglitch_s;      ///< time that the condition has to last after the step that first sees it
  std::string_view text;  ///< one sentence
  std::string_view causes;  ///< likely causes
  std::string_view check;   ///< what to look at
};

}  // namespace smaservo
