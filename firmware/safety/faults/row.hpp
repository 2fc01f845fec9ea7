#pragma once
// The description of one fault.

#include <cstdint>
#include <string_view>

#include "firmware/faults.hpp"

namespace smaservo {

enum class Clears : std::uint8_t {
  itself,       ///< the fault ends with its condition; nothing is latched
  command,      ///< by the command to clear, when the condition has gone
  acknowledge,  ///< by the command to clear, though the condition will stay
  reset,        ///< only by a restart
};

struct FaultRow {
  Fault fault;
  FaultClass severity;
  Clears clears;
  std::uint16_t code;  ///< error code of CiA 301, FFxxh where none fits; it never changes
  std::string_view name;
  double deglitch_s;        ///< the condition has to last so long after the step that first sees it
  std::string_view text;    ///< one sentence
  std::string_view causes;  ///< likely ones
  std::string_view check;   ///< what to look at
};

}  // namespace smaservo
