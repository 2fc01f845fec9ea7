#pragma once
// What there is to say about one fault.

#include <cstdint>
#include <string_view>

#include "firmware/faults.hpp"

namespace smaservo {

enum class Clears : std::uint8_t {
  itself,       ///< with its condition; nothing is latched
  command,      ///< by the command to clear, when the condition has gone
  acknowledge,  ///< by the command to clear, though the condition will stay
  reset,        ///< only by a restart
};

struct FaultRow {
  Fault fault;
  FaultClass severity;
  Clears clears;
  std::uint16_t code;  ///< for ever; an error code as CiA 301 has them, FFxxh where none fits
  std::string_view name;
  double deglitch_s;      ///< the condition has to last so long, beyond the step that first sees it
  std::string_view text;  ///< one sentence
  std::string_view causes;  ///< likely ones
  std::string_view check;   ///< what to look at
};

}  // namespace smaservo
