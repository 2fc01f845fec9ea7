#pragma once
// Properties of model, observer, controller, device and store in the scalar of the targets. The
// same source runs under GoogleTest on a PC and by itself on a microcontroller.

#include <span>
#include <string_view>

#include "firmware/settings.hpp"

namespace smaservo::mcu {

/// What went wrong first.
struct Verdict {
  std::string_view broken;  ///< empty: nothing

  void expect(bool holds, std::string_view what) {
    if (!holds && broken.empty()) {
      broken = what;
    }
  }
};

struct Check {
  std::string_view name;
  void (*run)(const Settings<float>& settings, Verdict& verdict);
};

std::span<const Check> checks();

}  // namespace smaservo::mcu
