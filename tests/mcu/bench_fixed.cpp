// Counts the instructions of the observer in integer arithmetic (model/scalar/scaled.hpp) on the
// first steps of step files, for processors without floating point. Prints lines of a name and
// numbers.

#include <optional>

#include "hal/cortex-m/start_up.hpp"
#include "model/scalar/scaled.hpp"
#include "tests/mcu/counting.hpp"
#include "tests/mcu/step_reader.hpp"

namespace smaservo::mcu {
namespace {

using S = Scaled;

[[gnu::noinline]] void observer_step(const Prepared<S>& p, Device<S>::State& s, const Inputs<S>& in,
                                     const S& dt_s) {
  Device<S>::observe(p, s, in, dt_s);
}

Prepared<S> prepared;  // static, as a firmware keeps it
Device<S>::State state;

bool count_file(std::string_view name) {
  static std::optional<StepReader> opened;
  StepReader& reader = opened.emplace(name);
  const auto settings = reader.settings<S>();
  if (!settings) {
    say("no settings in ", name, "\n");
    return false;
  }
  prepared = prepare(*settings);
  state = Device<S>::start();
  Counts observer;
  const StepRecord* r = reader.next();
  for (std::uint32_t i = 0; r != nullptr && i < steps_in_integers; ++i, r = reader.next()) {
    if ((r->inputs.flags & restart) != 0) {
      state = Device<S>::start();
    }
    const Inputs<S> in = inputs_of<S>(r->inputs);
    const S dt_s(r->inputs.dt_s);
    const bool observed = state.observing;
    const std::uint32_t count = instructions([&] { observer_step(prepared, state, in, dt_s); });
    if (observed) {
      observer.add(count);
    }
  }
  observer.print("fixed_observer", name.substr(name.rfind('/') + 1));
  return true;
}

}  // namespace
}  // namespace smaservo::mcu

int application() {
  return smaservo::mcu::count_files(smaservo::mcu::count_file);
}
