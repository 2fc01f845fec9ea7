// Counts the instructions of steps on step files. Prints lines of a name and numbers.

#include <algorithm>
#include <optional>

#include "firmware/mcu/device.hpp"
#include "hal/cortex-m/start_up.hpp"
#include "tests/mcu/counting.hpp"
#include "tests/mcu/model_triangle.hpp"
#include "tests/mcu/step_reader.hpp"

namespace smaservo::mcu {
namespace {

using S = float;

void count_model_steps(const Prepared<S>& prepared) {
  Counts counts;
  model_triangle(prepared, [&](auto step) { counts.add(instructions(step)); });
  counts.print("model", "triangle");
}

Prepared<S> prepared;  // static, as a firmware keeps it
Device<S>::State state, copy;

/// The stack that a step needs below its caller.
std::size_t step_stack(const StepInputs& r, const Inputs<S>& in, const Command<S>& command) {
  copy = state;
  cortex_m::repaint_stack();
  mcu::step_device(prepared, copy, in, command, r.dt_s);
  return cortex_m::stack_bytes();
}

bool count_file(std::string_view name) {
  static std::optional<StepReader> opened;
  StepReader& reader = opened.emplace(name);
  const auto settings = reader.settings<S>();
  if (!settings) {
    say("no settings in ", name, "\n");
    return false;
  }
  prepared = prepare(*settings);
  static bool first = true;
  if (first) {
    count_model_steps(prepared);
    first = false;
  }
  state = Device<S>::start();
  Counts device, observer, starts;
  std::size_t stack = 0;
  while (const StepRecord* r = reader.next()) {
    if ((r->inputs.flags & restart) != 0) {
      state = Device<S>::start();
    }
    const Inputs<S> in = inputs_of<S>(r->inputs);
    const Command<S> command = command_of<S>(r->inputs);
    if (device.steps % 64 == 0) {
      stack = std::max(stack, step_stack(r->inputs, in, command));
    }
    copy = state;
    const std::uint32_t observe =
        instructions([&] { mcu::observe_device(prepared, copy, in, r->inputs.dt_s); });
    const bool observed = state.observing;
    const std::uint32_t whole =
        instructions([&] { mcu::step_device(prepared, state, in, command, r->inputs.dt_s); });
    if (observed) {
      observer.add(observe);
      device.add(whole);
    } else {
      starts.add(whole);
    }
  }
  const std::string_view file = name.substr(name.rfind('/') + 1);
  device.print("device", file);
  observer.print("observer", file);
  starts.print("start", file);
  say("stack ", file, " ", stack, "\n");
  return true;
}

}  // namespace
}  // namespace smaservo::mcu

int application() {
  return smaservo::mcu::count_files(smaservo::mcu::count_file);
}
