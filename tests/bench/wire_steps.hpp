#pragma once
// What one tick of a loop asks of a simulated wire.

#include <cmath>
#include <memory>
#include <numbers>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "hal/sim/simulated_wire.hpp"
#include "tests/bench/steps.hpp"

namespace smaservo::benchmarks {

/// Strain, resistance and 1 ms, while the power goes up and down within 20 s and the stress swings
/// by 30 MPa within 4 s.
class WireStep {
 public:
  explicit WireStep(hal::Family family) {
    std::mt19937_64 random(1);
    wire_ = hal::make_simulated_wire(
        family, files::load_wire(std::string(files::default_wire)).wire, {}, 0.5, random);
    wire_->rest(ambient_K, stress_Pa);
    std::vector<Input> inputs;
    for (const Measurement<double>& m : measurements()) {
      const double time_s = 1e-3 * static_cast<double>(inputs.size());
      inputs.push_back({std::sqrt(m.power_W / m.resistance_ohm),
                        stress_Pa + 30e6 * std::sin(0.5 * std::numbers::pi * time_s)});
    }
    inputs_ = Cycle<Input>(std::move(inputs));
  }
  std::size_t period() const { return inputs_.size(); }
  void operator()() {
    const Input& u = inputs_.next();
    strain_ = wire_->strain();
    ohm_ = wire_->resistance_ohm();
    wire_->advance(u.current_A, {u.stress_Pa, ambient_K, 1}, 1e-3);
  }

 private:
  struct Input {
    double current_A, stress_Pa;
  };
  std::unique_ptr<hal::SimulatedWire> wire_;
  Cycle<Input> inputs_{{}};
  double strain_ = 0;
  double ohm_ = 0;
};

template <class F>
void for_each_wire_step(F f) {
  for (const hal::Family family : hal::families) {
    f("wire_step_" + std::string(hal::family_name(family)), [family] { return WireStep(family); });
  }
}

}  // namespace smaservo::benchmarks
